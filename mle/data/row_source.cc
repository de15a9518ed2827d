#include "mle/data/row_source.h"

#include "absl/strings/str_cat.h"

namespace mle {

bool RowSource::SkipLine() {
  std::vector<std::string_view> fields;
  return Next(fields);
}

std::string RowSource::LineName(int line) const {
  return CsvLineName(line, is_table_);
}

std::string RowSource::LinePlace() const {
  return absl::StrCat(source_, ": ", LineName(Origin(row_line_, 1).first));
}

std::string RowSource::PlaceIn(int line, int field) const {
  const auto [from_line, from_field] = Origin(line, field);
  return absl::StrCat(source_, ": ", LineName(from_line), ", column ",
                      from_field);
}

std::string CsvLineName(int line, bool is_table) {
  if (!is_table) return absl::StrCat("line ", line);
  return line > 1 ? absl::StrCat("row ", line - 1) : "header";
}

void RowBlock::Add(std::string_view field) {
  text_ += field;
  ends_.push_back(text_.size());
}

void RowBlock::Clear() {
  text_.clear();
  ends_.clear();
}

void RowBlock::Get(std::size_t first, std::size_t count,
                   std::vector<std::string_view>& fields) const {
  fields.clear();
  std::size_t begin = first == 0 ? 0 : ends_[first - 1];
  for (std::size_t c = first; c < first + count; ++c) {
    fields.push_back(std::string_view(text_).substr(begin, ends_[c] - begin));
    begin = ends_[c];
  }
}

}  // namespace mle
