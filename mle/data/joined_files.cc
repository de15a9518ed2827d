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
#include "mle/data/csv_rows.h"
#include "mle/data/long_table.h"
#include "mle/data/nearest_names.h"
#include "mle/data/quality_columns.h"
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

// What a file has of a long table.
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

// The rows of a file as those of the long table.
absl::Status AppendRows(const HistorianSource& source,
                        const HistorianColumns& columns,
                        const FileColumns& found, bool has_quality,
                        const CsvLimits& limits, std::string& text) {
  MLE_ASSIGN_OR_RETURN(const std::unique_ptr<std::istream> in, source.open());
  CsvRows rows(*in, source.name, limits);
  rows.set_separator(columns.separator);
  rows.set_is_table(source.is_table);
  std::vector<std::string_view> fields;
  const auto is_header = [&] {
    return std::equal(fields.begin(), fields.end(), columns.header.begin(),
                      columns.header.end());
  };
  while (rows.Next(fields) && !is_header()) {
  }
  rows.set_skips_comments();
  while (rows.Next(fields)) {
    if (static_cast<int>(fields.size()) <= found.last()) {
      return absl::InvalidArgumentError(absl::StrCat(
          rows.Place(static_cast<int>(fields.size())), ": the row ends after ",
          fields.size(), " fields, before its ", found.last() + 1, "th"));
    }
    std::string time(TrimCsvField(fields[found.time]));
    if (!HasAnyDigit(time)) continue;  // units, or the header again
    if (found.time_part >= 0) {
      time = JoinTimeFields(time, fields[found.time_part]);
    }
    for (const TagColumn& tag : found.tags) {
      absl::StrAppend(&text, QuoteCsvField(time), ",", QuoteCsvField(tag.tag),
                      ",", QuoteCsvField(TrimCsvField(fields[tag.value])));
      if (has_quality) {
        text += ',';
        text += found.quality < 0
                    ? "Good"
                    : QuoteCsvField(TrimCsvField(fields[found.quality]));
      }
      text += '\n';
    }
  }
  return rows.status();
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

absl::StatusOr<std::optional<JoinedFiles>> JoinFiles(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options) {
  if (sources.size() < 2 || options.clocks.size() > 1 ||
      !options.header.empty()) {
    return std::nullopt;
  }
  const std::vector<std::string> wanted = WantedTags(channels, options.columns);
  std::vector<HistorianColumns> columns;
  std::vector<FileColumns> found;
  std::set<std::string> tags;
  std::set<QualityKind> kinds;
  std::size_t most = 0;
  for (const HistorianSource& source : sources) {
    const absl::StatusOr<HistorianColumns> of_file =
        HistorianFile::Columns(source, channels, options);
    if (!of_file.ok()) return std::nullopt;
    const auto file = FindColumns(source, *of_file, wanted, options.columns);
    if (!file) return std::nullopt;
    for (const TagColumn& tag : file->tags) tags.insert(tag.tag);
    if (file->quality >= 0) kinds.insert(file->kind);
    most = std::max(most, file->tags.size());
    columns.push_back(*of_file);
    found.push_back(*file);
  }
  if (tags.size() <= most || kinds.size() > 1) return std::nullopt;
  JoinedFiles joined = {{}, options};
  std::string text = "time,tag,value";
  joined.options.columns.quality_column.clear();
  if (!kinds.empty()) {
    joined.options.columns.quality_column = UsualQualityName(*kinds.begin());
    absl::StrAppend(&text, ",", joined.options.columns.quality_column);
  }
  text += '\n';
  for (std::size_t f = 0; f < sources.size(); ++f) {
    MLE_RETURN_IF_ERROR(AppendRows(sources[f], columns[f], found[f],
                                   !kinds.empty(), options.limits, text));
  }
  joined.source = TextSource(NameOfAll(sources), std::move(text));
  joined.options.columns.time_column = ColumnOptions().time_column;
  joined.options.columns.tag_column = "tag";
  joined.options.columns.value_column = "value";
  joined.options.separator = 0;
  joined.options.lines_above_header = 0;
  joined.options.rows_below_header = 0;
  joined.options.header.clear();
  return joined;
}

}  // namespace mle
