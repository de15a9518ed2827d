// What the fuzz targets share.
//
// A target is a function of bytes that must not crash, hang or break one of its
// promises, whatever the bytes. libFuzzer looks for bytes that do; built
// without it, a target replays the files it is given.

#ifndef TESTS_FUZZ_FUZZ_H_
#define TESTS_FUZZ_FUZZ_H_

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

// A promise that does not hold ends the program: libFuzzer keeps the bytes.
#define FUZZ_EXPECT(condition, ...)                                         \
  do {                                                                      \
    if (!(condition)) {                                                     \
      std::fprintf(stderr, "%s:%d: %s does not hold: %s\n", __FILE__,       \
                   __LINE__, #condition, std::string(__VA_ARGS__).c_str()); \
      std::abort();                                                         \
    }                                                                       \
  } while (false)

namespace mle::fuzz {

// Takes small values off the front of the bytes; zeros once they are used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size)
      : text_(reinterpret_cast<const char*>(data), size) {}

  bool empty() const { return text_.empty(); }
  std::uint8_t Next() {
    if (text_.empty()) return 0;
    const auto byte = static_cast<std::uint8_t>(text_.front());
    text_.remove_prefix(1);
    return byte;
  }
  // In [low, high], high − low < 256.
  int Between(int low, int high) { return low + Next() % (high - low + 1); }
  bool Flag() { return Next() % 2 != 0; }
  // Small whole numbers most of the time, so that ties are common; tenths,
  // powers of ten and rounding errors at others.
  double Number();
  std::string_view Rest() const { return text_; }
  // Up to the next `mark`, which is taken too; else all.
  std::string_view Until(std::string_view mark) {
    const std::size_t end = text_.find(mark);
    const std::string_view part = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size()
                                                      : end + mark.size());
    return part;
  }

 private:
  std::string_view text_;
};

inline double Bytes::Number() {
  const int byte = Next();
  if (byte < 128) return byte % 11 - 5;
  if (byte < 192) return (byte - 160) / 10.0;
  const int sign = byte % 2 == 0 ? 1 : -1;
  if (byte < 224) {  // 1e-8 … 1e8
    double power = sign;
    for (int i = 0; i < (byte - 192) / 2 % 9; ++i) {
      power *= byte < 208 ? 10.0 : 0.1;
    }
    return power;
  }
  return (byte % 5 - 2) + sign * 1e-12 * (byte - 223);
}

}  // namespace mle::fuzz

#endif  // TESTS_FUZZ_FUZZ_H_
