#include "mle/data/missing_channels.h"

#include <algorithm>
#include <map>
#include <set>

#include "absl/strings/ascii.h"
#include "mle/base/status.h"
#include "mle/data/historian_file.h"
#include "mle/data/joined_files.h"
#include "mle/data/nearest_names.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

std::string DigitsOf(const std::string& name) {
  std::string digits;
  for (const char c : name) {
    if (absl::ascii_isdigit(static_cast<unsigned char>(c))) digits += c;
  }
  return digits;
}

// FC101 is not FC102 mistyped; FC 101.PV may be FC101.
bool MayBeMeant(const std::string& name,
                const std::vector<std::string>& columns) {
  const std::vector<std::string> near = NearestNames(name, columns);
  return std::any_of(near.begin(), near.end(), [&](const std::string& other) {
    return DigitsOf(name) == DigitsOf(other);
  });
}

}  // namespace

absl::StatusOr<std::vector<std::string>> MissingChannels(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options) {
  std::set<std::string> unused;
  for (const std::string& name : options.columns.unused_tags) {
    unused.insert(FoldedName(name));
  }
  const std::vector<std::string> wanted_tags =
      WantedTags(channels, options.columns);
  std::map<std::string, std::string> found;  // by their folded names
  for (const HistorianSource& source : sources) {
    MLE_ASSIGN_OR_RETURN(const HistorianColumns columns,
                         HistorianFile::Columns(source, channels, options));
    for (const std::string& name : TagsOf(source, columns, wanted_tags)) {
      if (!unused.contains(FoldedName(name))) found[FoldedName(name)] = name;
    }
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> known,
                       ColumnsOf(channels));
  std::map<std::string, std::string> wanted;  // the columns, by their channels
  for (const RecordColumn& column : known) {
    if (column.kind != Kind::kTime) wanted[column.name] = column.name;
  }
  for (const TagMapping& tag : options.columns.tags) {
    wanted[tag.channel] = tag.tag;
  }
  std::map<std::string, std::string> free = found;
  for (const auto& [channel, column] : wanted) free.erase(FoldedName(column));
  std::vector<std::string> others;
  for (const auto& [folded, name] : free) others.push_back(name);
  std::vector<std::string> missing;
  for (const RecordColumn& column : known) {
    if (column.kind != Kind::kOutput && column.kind != Kind::kInput) continue;
    const std::string& name = wanted.at(column.name);
    // A column of the channel's name is one, whatever tag was declared.
    if (!found.contains(FoldedName(name)) && !MayBeMeant(name, others) &&
        !found.contains(FoldedName(column.name))) {
      missing.push_back(column.name);
    }
  }
  return missing;
}

}  // namespace mle
