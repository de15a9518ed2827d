#include "apps/report/font.h"

#include <array>

#include "apps/report/text.h"

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

}  // namespace mle::report
