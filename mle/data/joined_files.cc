#include "mle/data/joined_files.h"

#include <algorithm>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/long_table.h"
#include "mle/data/nearest_names.h"
#include "mle/data/quality_columns.h"
#include "mle/data/row_source.h"
#include "mle/data/time_columns.h"

namespace mle {
namespace {

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// "TI101.PV" of "export/TI101.PV.csv.gz".
std::string NameOfFile(const std::string& path) {
  std::string name = path.substr(path.find_last_of("/\\") + 1);
  for (const std::string_view ending : {".gz", ".csv", ".txt", ".tsv"}) {
    if (absl::AsciiStrToLower(name).ends_with(ending)) {
      name.resize(name.size() - ending.size());
    }
  }
  return name;
}

// A name that columns of values have in any table.
bool IsValueName(const std::string& name) {
  const std::string folded = FoldedName(name);
  return Contains(LongColumnNames({}), folded) &&
         !Contains(UsualTimeColumns(), folded);
}

int PlaceOfName(const std::vector<std::string>& header,
                const std::string& name) {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

// A column of values in a file, and the tag that it has in the long table.
struct TagColumn {
  int value = -1;
  std::string tag;
};

struct FileColumns {
  int time = -1;
  int time_part = -1;
  int quality = -1;
  QualityKind kind = QualityKind::kCode;
  std::vector<TagColumn> tags;

  int last() const {
    int last = std::max({time, time_part, quality});
    for (const TagColumn& tag : tags) last = std::max(last, tag.value);
    return last;
  }
};

void FindTime(const HistorianColumns& columns, FileColumns& found) {
  const std::vector<std::string>& header = columns.header;
  if (const auto parts = SplitTimeName(columns.time_column, header)) {
    found.time = PlaceOfName(header, parts->first);
    found.time_part = PlaceOfName(header, parts->second);
    return;
  }
  for (std::size_t c = 0; c < header.size() && found.time < 0; ++c) {
    const std::string folded = FoldedName(header[c]);
    if (folded == FoldedName(columns.time_column) ||
        Contains(UsualTimeColumns(), folded)) {
      found.time = static_cast<int>(c);
    }
  }
}

// The quality of the one tag of a file. False for more than one: which tag each
// is of would be lost.
bool FindQuality(const HistorianColumns& columns,
                 const std::vector<std::string>& suffixes, FileColumns& found) {
  std::vector<std::string_view> tags;
  for (const TagColumn& tag : found.tags) {
    tags.emplace_back(columns.header[tag.value]);
  }
  for (std::size_t c = 0; c < columns.header.size(); ++c) {
    const std::string& name = columns.header[c];
    if (std::find(tags.begin(), tags.end(), name) != tags.end()) continue;
    const auto quality = QualityOfName(name, tags);
    const bool is_named = std::any_of(
        suffixes.begin(), suffixes.end(), [&](const std::string& suffix) {
          return !suffix.empty() && name.ends_with(suffix);
        });
    if (!quality && !is_named) continue;
    if (found.tags.size() > 1 || found.quality >= 0) return false;
    found.quality = static_cast<int>(c);
    found.kind = is_named || !quality ? QualityKind::kCode : quality->kind;
  }
  return true;
}

std::optional<FileColumns> FindColumns(const HistorianSource& source,
                                       const HistorianColumns& columns,
                                       const std::vector<std::string>& wanted,
                                       const ColumnOptions& options) {
  FileColumns found;
  FindTime(columns, found);
  if (columns.is_long || found.time < 0) return std::nullopt;
  const std::vector<std::string> tags = TagsOf(source, columns, wanted);
  if (tags.empty()) return std::nullopt;
  for (const std::string& tag : tags) {
    int column = PlaceOfName(columns.header, tag);
    if (column < 0) column = PlaceOfName(columns.header, columns.OnlyValue());
    if (column < 0) return std::nullopt;
    found.tags.push_back({column, tag});
  }
  if (!FindQuality(columns, options.quality_suffixes, found)) {
    return std::nullopt;
  }
  return found;
}

bool HasAnyDigit(std::string_view text) {
  return text.find_first_of("0123456789") != std::string_view::npos;
}

// A file and what it has of the long table.
struct JoinedFile {
  HistorianSource source;
  HistorianColumns columns;
  FileColumns found;
};

// The rows of files one after another as those of a long table.
class JoinedRows : public RowSource {
 public:
  JoinedRows(std::string name,
             std::shared_ptr<const std::vector<JoinedFile>> files,
             std::string quality, const CsvLimits& limits)
      : RowSource(std::move(name)),
        files_(std::move(files)),
        quality_(std::move(quality)),
        limits_(limits) {}

  bool Next(std::vector<std::string_view>& fields) override;
  std::unique_ptr<RowSource> Preview() override {
    return std::make_unique<JoinedRows>(source(), files_, quality_, limits_);
  }

 private:
  bool Open();
  bool NextRow();

  const std::shared_ptr<const std::vector<JoinedFile>> files_;
  const std::string quality_;  // the name of its column; empty: none
  const CsvLimits limits_;
  std::size_t file_ = 0;
  std::unique_ptr<RowSource> rows_;  // of the file; null before it is opened
  std::vector<std::string_view> row_;
  std::string time_;
  std::size_t tag_ = 0;  // the next one of the row
};

// The next file, up to its header.
bool JoinedRows::Open() {
  const JoinedFile& file = (*files_)[file_];
  absl::StatusOr<std::unique_ptr<RowSource>> rows =
      OpenRows(file.source, file.columns.separator, limits_);
  status_ = rows.status();
  if (!status_.ok()) return false;
  rows_ = *std::move(rows);
  while (rows_->Next(row_) &&
         !std::equal(row_.begin(), row_.end(), file.columns.header.begin(),
                     file.columns.header.end())) {
  }
  rows_->set_skips_comments();
  return true;
}

// The next row that has a time, of any file.
bool JoinedRows::NextRow() {
  while (file_ < files_->size()) {
    if (rows_ == nullptr && !Open()) return false;
    const FileColumns& found = (*files_)[file_].found;
    while (rows_->Next(row_)) {
      if (static_cast<int>(row_.size()) <= found.last()) {
        status_ = InvalidArgument(rows_->Place(static_cast<int>(row_.size())),
                                  ": the row ends after ", row_.size(),
                                  " fields, it needs ", found.last() + 1);
        return false;
      }
      time_ = std::string(TrimCsvField(row_[found.time]));
      if (!HasAnyDigit(time_)) continue;  // units, or the header again
      if (found.time_part >= 0) {
        time_ = JoinTimeFields(time_, row_[found.time_part]);
      }
      tag_ = 0;
      return true;
    }
    status_ = rows_->status();
    if (!status_.ok()) return false;
    rows_.reset();
    ++file_;
  }
  return false;
}

bool JoinedRows::Next(std::vector<std::string_view>& fields) {
  if (!status_.ok()) return false;
  if (++row_line_ == 1) {
    fields = {"time", "tag", "value"};
    if (!quality_.empty()) fields.push_back(quality_);
    return true;
  }
  const bool is_first = rows_ == nullptr;
  if (is_first || tag_ == (*files_)[file_].found.tags.size()) {
    if (!NextRow()) return false;
  }
  const FileColumns& found = (*files_)[file_].found;
  const TagColumn& tag = found.tags[tag_++];
  fields = {time_, tag.tag, TrimCsvField(row_[tag.value])};
  if (!quality_.empty()) {
    fields.push_back(found.quality < 0 ? "Good"
                                       : TrimCsvField(row_[found.quality]));
  }
  return true;
}

std::string NameOfAll(const std::vector<HistorianSource>& sources) {
  const std::size_t more = sources.size() - 1;
  return absl::StrCat(sources[0].name, " and ", more, " more, joined");
}

}  // namespace

std::string HistorianColumns::OnlyValue() const {
  if (names.size() == 1) return names[0];
  std::string only;
  for (const std::string& name : header) {
    if (!IsValueName(name)) continue;
    if (!only.empty()) return "";
    only = name;
  }
  return only;
}

std::vector<std::string> WantedTags(const ProcessModel& channels,
                                    const ColumnOptions& options) {
  std::vector<std::string> wanted;
  for (const std::string& name : ChannelNames(channels)) {
    wanted.push_back(FoldedName(name));
  }
  for (const TagMapping& tag : options.tags) {
    wanted.push_back(FoldedName(tag.tag));
  }
  return wanted;
}

std::vector<std::string> TagsOf(const HistorianSource& source,
                                const HistorianColumns& columns,
                                const std::vector<std::string>& wanted) {
  const bool is_known = std::any_of(columns.names.begin(), columns.names.end(),
                                    [&](const std::string& name) {
                                      return Contains(wanted, FoldedName(name));
                                    });
  const std::string file = NameOfFile(source.name);
  if (!is_known && !columns.is_long && !columns.OnlyValue().empty() &&
      (columns.names.empty() || Contains(wanted, FoldedName(file)))) {
    return {file};
  }
  return columns.names;
}

std::optional<JoinedFiles> JoinFiles(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options) {
  if (sources.size() < 2 || options.clocks.size() > 1 ||
      !options.header.empty()) {
    return std::nullopt;
  }
  const std::vector<std::string> wanted = WantedTags(channels, options.columns);
  auto files = std::make_shared<std::vector<JoinedFile>>();
  std::set<std::string> tags;
  std::set<QualityKind> kinds;
  std::size_t most = 0;
  for (const HistorianSource& source : sources) {
    const absl::StatusOr<HistorianColumns> columns =
        HistorianFile::Columns(source, channels, options);
    if (!columns.ok()) return std::nullopt;
    const auto found = FindColumns(source, *columns, wanted, options.columns);
    if (!found) return std::nullopt;
    for (const TagColumn& tag : found->tags) tags.insert(tag.tag);
    if (found->quality >= 0) kinds.insert(found->kind);
    most = std::max(most, found->tags.size());
    files->push_back({source, *columns, *found});
  }
  if (tags.size() <= most || kinds.size() > 1) return std::nullopt;
  JoinedFiles joined = {{}, options};
  joined.options.columns.time_column = ColumnOptions().time_column;
  joined.options.columns.tag_column = "tag";
  joined.options.columns.value_column = "value";
  joined.options.columns.quality_column =
      kinds.empty() ? "" : UsualQualityName(*kinds.begin());
  joined.source.name = NameOfAll(sources);
  joined.source.open_rows =
      [name = joined.source.name, files,
       quality = joined.options.columns.quality_column,
       limits =
           options.limits]() -> absl::StatusOr<std::unique_ptr<RowSource>> {
    return std::make_unique<JoinedRows>(name, files, quality, limits);
  };
  return joined;
}

}  // namespace mle
