// Columns that say how good samples are, by the names and values that
// historians give them. Internal to this project: not installed.
//
//   TI101_quality, TI101.OPCQuality, TI101::status, TI101 Good, Quality TI101
//   TI101_Questionable, TI101_Substituted     true of samples that are not used

#ifndef MLE_DATA_QUALITY_COLUMNS_H_
#define MLE_DATA_QUALITY_COLUMNS_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mle {

// Content of a quality column.
enum class QualityKind {
  kCode,        // a word or a number: Good, 192
  kFlag,        // whether the sample is good
  kFault,       // whether it is not (questionable, substituted)
  kConfidence,  // per cent
};

// Words for bad samples, whatever their case: Bad, Bad Input, No Data, I/O
// Timeout, null, N/A, …
const std::vector<std::string>& KnownBadWords();

// The samples whose quality a column of this name describes, and the kind of
// its content.
struct QualityName {
  std::string_view column;  // of the samples it speaks of; empty: of all
  QualityKind kind = QualityKind::kCode;
};

// Nothing for other names. Of several of `columns` the longest.
std::optional<QualityName> QualityOfName(
    std::string_view name, const std::vector<std::string_view>& columns);

// The name that columns of a kind usually have: "quality", "isgood", ….
std::string UsualQualityName(QualityKind kind);

// Whether the default of ColumnOptions::quality_suffixes or of
// HistorianOptions::good_qualities was left, so that usual names and values
// count too.
bool AreUsualSuffixes(const std::vector<std::string>& suffixes);
bool AreUsualQualities(const std::vector<std::string>& good);

// Good, GoodNonSpecific, 192 to 255 (OPC: the two highest bits of its byte), …;
// True, Yes, 1 of a flag; False, No, 0 and nothing of a fault; 100 of a
// confidence.
bool IsUsuallyGood(std::string_view quality, QualityKind kind);

}  // namespace mle

#endif  // MLE_DATA_QUALITY_COLUMNS_H_
