#include "mle/data/historian.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/file_kind.h"

namespace mle {
namespace {

absl::StatusOr<std::unique_ptr<std::istream>> OpenFile(
    const std::string& path) {
  MLE_RETURN_IF_ERROR(CheckRegularFile(path));
  auto in = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*in) {
    MLE_RETURN_IF_ERROR(ReadFile(path).status());
    return absl::UnavailableError(absl::StrCat("cannot read '", path, "'"));
  }
  return in;
}

// The stream itself, or what is packed in it.
std::unique_ptr<std::istream> Unpacked(std::unique_ptr<std::istream> in) {
  std::array<char, 3> start = {};
  in->read(start.data(), start.size());
  const auto size = static_cast<std::size_t>(in->gcount());
  in->clear();
  in->seekg(0);
  return IsGzip({start.data(), size}) ? Gunzip(std::move(in)) : std::move(in);
}

}  // namespace

std::string_view StandardInput() {
  static const std::string& text =
      *new std::string(std::istreambuf_iterator<char>(std::cin.rdbuf()), {});
  return text;
}

HistorianSource FileSource(const std::string& path) {
  if (path == "-") {
    return {kStandardInput,
            []() -> absl::StatusOr<std::unique_ptr<std::istream>> {
              return Unpacked(std::make_unique<std::istringstream>(
                  std::string(StandardInput())));
            }};
  }
  HistorianSource source = {
      path, [path]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
        MLE_ASSIGN_OR_RETURN(std::unique_ptr<std::istream> in, OpenFile(path));
        return Unpacked(std::move(in));
      }};
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (!error) source.bytes = static_cast<std::int64_t>(bytes);
  return source;
}

HistorianSource TextSource(std::string name, std::string text) {
  return {std::move(name),
          [text = std::move(
               text)]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
            return std::make_unique<std::istringstream>(text);
          }};
}

}  // namespace mle
