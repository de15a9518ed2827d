// Files that are no text, known by their first bytes, and their contents where
// these are compressed text. Internal to mle/data.

#ifndef MLE_DATA_FILE_KIND_H_
#define MLE_DATA_FILE_KIND_H_

#include <cstddef>
#include <istream>
#include <memory>
#include <string_view>

namespace mle {

// "an Excel workbook (xlsx); save its sheet as CSV …": what a file that begins
// so is, and what to do with it; empty for what may be text.
std::string_view NotText(std::string_view start);

// Whether a file that begins so is compressed by gzip (RFC 1952).
bool IsGzip(std::string_view start);

// The text of `compressed`, unpacked while it is read; parts that were joined
// to one file are read one after the other. A file that is damaged or cut ends
// in a stream that is bad().
std::unique_ptr<std::istream> Gunzip(std::unique_ptr<std::istream> compressed);

}  // namespace mle

#endif  // MLE_DATA_FILE_KIND_H_
