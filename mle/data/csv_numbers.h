// Numbers in CSV files, independent of the locale.

#ifndef MLE_DATA_CSV_NUMBERS_H_
#define MLE_DATA_CSV_NUMBERS_H_

#include <string>
#include <string_view>

namespace mle {

inline constexpr int kCsvTimeDigits = 12;

// The whole of `text` as a number, "nan" and "inf" included, with `decimal` (a
// point or a comma) before its decimals; false if it is not a number, or is out
// of the range of a double.
bool ReadCsvNumber(std::string_view text, double& number, char decimal = '.');

// With the fewest digits that read back as the same double.
void AppendCsvNumber(double number, std::string& text);

// To kCsvTimeDigits significant digits.
double RoundCsvTime(double time);

// Without the blanks around it, and without the apostrophe before what a
// spreadsheet would compute.
std::string_view TrimCsvField(std::string_view text);

// Whether a spreadsheet would compute the field: "=1+1", "@SUM(A1)", "-A1", but
// not a number or a sign alone.
bool IsComputed(std::string_view field);

// The first name of a header, without a # that makes the header a comment.
std::string_view WithoutHash(std::string_view text);

}  // namespace mle

#endif  // MLE_DATA_CSV_NUMBERS_H_
