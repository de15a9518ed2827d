#include "apps/report/text.h"

#include <array>
#include <cstddef>

#include "absl/strings/ascii.h"
#include "absl/strings/str_replace.h"

namespace mle::report {
namespace {

// Advance widths of U+0020 … U+007E, in 1/2048 of the font size.
constexpr std::array<int, 95> kAdvance = {
    651,  821,  942,  1716, 1303, 1946, 1597, 563,  799,  799,  1024, 1716,
    651,  739,  651,  690,  1303, 1303, 1303, 1303, 1303, 1303, 1303, 1303,
    1303, 1303, 690,  690,  1716, 1716, 1716, 1087, 2048, 1401, 1405, 1430,
    1577, 1294, 1178, 1587, 1540, 604,  604,  1343, 1141, 1767, 1532, 1612,
    1235, 1612, 1423, 1300, 1251, 1499, 1401, 2025, 1403, 1251, 1403, 799,
    690,  799,  1716, 1024, 1024, 1255, 1300, 1126, 1300, 1260, 721,  1300,
    1298, 569,  569,  1186, 569,  1995, 1298, 1253, 1300, 1300, 842,  1067,
    803,  1298, 1212, 1675, 1212, 1212, 1075, 1303, 690,  1303, 1716};

double Advance(char32_t code) {
  if (code >= 0x20 && code <= 0x7E) return kAdvance[code - 0x20] / 2048.0;
  const bool superscript = code == 0xB2 || code == 0xB3 || code == 0xB9 ||
                           (code >= 0x2070 && code <= 0x209C);
  if (superscript) return code == 0x207B ? 0.55 : 0.42;
  if (code == U'×') return 0.84;
  if (code >= 0xA0 && code < 0x2000) return 0.7;  // Latin, Greek, Cyrillic
  if (DisplayWidth(Utf8(code)) > 1) return 1.4;
  return 1.0;
}

}  // namespace

double TextWidth(std::string_view text) {
  double width = 0.0;
  for (const char32_t code : CodePoints(text)) width += Advance(code);
  return width;
}

std::string Ellipsized(std::string_view text, double width) {
  if (TextWidth(text) <= width) return CleanText(text);
  double used = Advance(U'…');
  std::string out;
  for (const char32_t code : CodePoints(text)) {
    used += Advance(code);
    if (used > width) break;
    out += Utf8(code);
  }
  return out + "…";
}

namespace {

constexpr char32_t kReplacement = 0xFFFD;

struct CodeRange {
  char32_t first;
  char32_t last;
};

template <std::size_t n>
bool IsIn(char32_t c, const std::array<CodeRange, n>& ranges) {
  for (const CodeRange& range : ranges) {
    if (c >= range.first && c <= range.last) return true;
  }
  return false;
}

// C0 and C1, line and paragraph separators, and the marks that reorder text.
bool IsControl(char32_t c) {
  static constexpr std::array<CodeRange, 6> kControls = {{{0x00, 0x1F},
                                                          {0x7F, 0x9F},
                                                          {0x200E, 0x200F},
                                                          {0x2028, 0x202E},
                                                          {0x2066, 0x2069},
                                                          {0xFEFF, 0xFEFF}}};
  return IsIn(c, kControls);
}

bool IsCombining(char32_t c) {
  static constexpr std::array<CodeRange, 6> kCombining = {{{0x0300, 0x036F},
                                                           {0x1AB0, 0x1AFF},
                                                           {0x1DC0, 0x1DFF},
                                                           {0x200B, 0x200D},
                                                           {0x20D0, 0x20FF},
                                                           {0xFE00, 0xFE0F}}};
  return IsIn(c, kCombining);
}

bool IsWide(char32_t c) {
  static constexpr std::array<CodeRange, 9> kWide = {{{0x1100, 0x115F},
                                                      {0x2E80, 0x303E},
                                                      {0x3041, 0xA4CF},
                                                      {0xAC00, 0xD7A3},
                                                      {0xF900, 0xFAFF},
                                                      {0xFE30, 0xFE6F},
                                                      {0xFF00, 0xFF60},
                                                      {0x1F300, 0x1FAFF},
                                                      {0x20000, 0x3FFFD}}};
  return IsIn(c, kWide);
}

// Reads one code point at `at` and moves past it; one byte if it is no UTF-8.
char32_t Decode(std::string_view text, std::size_t& at) {
  const auto byte = [&](std::size_t i) {
    return static_cast<unsigned char>(text[i]);
  };
  const unsigned char lead = byte(at++);
  if (lead < 0x80) return lead;
  if (lead < 0xC2 || lead > 0xF4) return kReplacement;
  const int following = lead < 0xE0 ? 1 : lead < 0xF0 ? 2 : 3;
  if (at + following > text.size()) return kReplacement;
  char32_t code = lead & (0x3Fu >> following);
  for (int i = 0; i < following; ++i) {
    const unsigned char next = byte(at + i);
    if ((next & 0xC0u) != 0x80u) return kReplacement;
    code = (code << 6) | (next & 0x3Fu);
  }
  constexpr char32_t kSmallestOfLength[] = {0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < kSmallestOfLength[following] || code > 0x10FFFF || surrogate) {
    return kReplacement;
  }
  at += following;
  return code;
}
}  // namespace

std::vector<char32_t> CodePoints(std::string_view text) {
  std::vector<char32_t> points;
  points.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    char32_t code = Decode(text, at);
    if (IsControl(code)) code = U' ';
    // Unicode says these are no characters; XML forbids some of them.
    if ((code & 0xFFFEu) == 0xFFFEu || (code >= 0xFDD0 && code <= 0xFDEF)) {
      code = kReplacement;
    }
    points.push_back(code);
  }
  return points;
}

std::string Utf8(char32_t code) {
  if (code < 0x80) return std::string(1, static_cast<char>(code));
  constexpr char32_t kLead[] = {0, 0xC0, 0xE0, 0xF0};
  const int following = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
  std::string out(
      1, static_cast<char>(kLead[following] | (code >> (6 * following))));
  for (int i = following - 1; i >= 0; --i) {
    out += static_cast<char>(0x80u | ((code >> (6 * i)) & 0x3Fu));
  }
  return out;
}

std::string CleanText(std::string_view text) {
  std::string out;
  for (const char32_t code : CodePoints(text)) out += Utf8(code);
  return out;
}

std::string EscapeHtml(std::string_view text) {
  return absl::StrReplaceAll(CleanText(text), {{"&", "&amp;"},
                                               {"<", "&lt;"},
                                               {">", "&gt;"},
                                               {"\"", "&quot;"},
                                               {"'", "&#39;"}});
}

std::string WithSignsKept(std::string_view text) {
  constexpr const char* kNoBreak = "\u00A0";
  std::string out(text);
  for (std::size_t at = out.find(" %"); at != std::string::npos;
       at = out.find(" %", at + 1)) {
    if (at > 0 &&
        absl::ascii_isdigit(static_cast<unsigned char>(out[at - 1]))) {
      out.replace(at, 1, kNoBreak);
    }
  }
  for (const char* const sign : {"±", "×", "←"}) {
    absl::StrReplaceAll(
        {{std::string(sign) + " ", sign + std::string(kNoBreak)}}, &out);
  }
  return out;
}

std::string RelativeUrl(std::string_view path) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
      "-_.~/";
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string url = "./";
  for (const char c : path) {
    if (kPlain.find(c) != std::string_view::npos) {
      url += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    url += '%';
    url += kHex[byte / 16];
    url += kHex[byte % 16];
  }
  return url;
}

std::string EscapeHtmlLines(std::string_view text) {
  std::string out;
  for (;;) {
    const std::size_t end = text.find_first_of("\n\t");
    out += EscapeHtml(text.substr(0, end));
    if (end == std::string_view::npos) return out;
    out += text[end];
    text.remove_prefix(end + 1);
  }
}

int DisplayWidth(std::string_view text) {
  int width = 0;
  for (const char32_t code : CodePoints(text)) {
    width += IsCombining(code) ? 0 : IsWide(code) ? 2 : 1;
  }
  return width;
}

std::string QuoteCommandLine(const std::vector<std::string>& arguments) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
      "_@%+=:,./-";
  std::string line;
  for (const std::string& argument : arguments) {
    if (!line.empty()) line += ' ';
    if (!argument.empty() &&
        argument.find_first_not_of(kPlain) == std::string::npos) {
      line += argument;
      continue;
    }
    line += "'" + absl::StrReplaceAll(argument, {{"'", "'\\''"}}) + "'";
  }
  return line;
}

}  // namespace mle::report
