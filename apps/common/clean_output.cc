#include "apps/common/clean_output.h"

#include <algorithm>
#include <iostream>
#include <string_view>

namespace mle {
namespace {

constexpr std::string_view kReplacement = "\uFFFD";

bool IsControl(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7f;
}

std::streambuf* unclean_errors = nullptr;

}  // namespace

CleanBuffer::int_type CleanBuffer::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) {
    return traits_type::not_eof(c);
  }
  const char byte = traits_type::to_char_type(c);
  return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
}

std::streamsize CleanBuffer::xsputn(const char* text, std::streamsize size) {
  const char* const end = text + size;
  for (const char* from = text; from != end;) {
    const char* const control = std::find_if(from, end, IsControl);
    const std::streamsize clean = control - from;
    if (to_->sputn(from, clean) != clean) return from - text;
    from = control;
    if (control == end) break;
    const auto bytes = static_cast<std::streamsize>(kReplacement.size());
    if (to_->sputn(kReplacement.data(), bytes) != bytes) return from - text;
    ++from;
  }
  return size;
}

void CleanOutput() {
  if (unclean_errors != nullptr) return;
  // Used until the very end of the program.
  static auto* const kOut = new CleanBuffer(std::cout.rdbuf());
  static auto* const kErrors = new CleanBuffer(std::cerr.rdbuf());
  unclean_errors = std::cerr.rdbuf();
  std::cout.rdbuf(kOut);
  std::cerr.rdbuf(kErrors);
}

std::streambuf* UncleanErrors() {
  return unclean_errors == nullptr ? std::cerr.rdbuf() : unclean_errors;
}

}  // namespace mle
