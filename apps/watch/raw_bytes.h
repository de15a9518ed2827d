// Numbers as the state keeps them: their bytes, little-endian, one after the
// other; counts in as many bytes as they need, seven bits in each, the lowest
// first, and the eighth where more follow.

#ifndef APPS_WATCH_RAW_BYTES_H_
#define APPS_WATCH_RAW_BYTES_H_

#include <bit>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

namespace mle::watch {

static_assert(std::endian::native == std::endian::little,
              "the state is kept in little-endian order");

template <typename Number>
void PutRaw(Number value, std::string& bytes) {
  char raw[sizeof(value)];
  std::memcpy(raw, &value, sizeof(value));
  bytes.append(raw, sizeof(value));
}

// Takes the first number off `bytes`, which hold one.
template <typename Number>
Number TakeRaw(std::string_view& bytes) {
  Number value{};
  std::memcpy(&value, bytes.data(), sizeof(value));
  bytes.remove_prefix(sizeof(value));
  return value;
}

inline void PutCount(std::size_t count, std::string& bytes) {
  for (; count >= 0x80; count >>= 7) {
    bytes += static_cast<char>(0x80 | (count & 0x7f));
  }
  bytes += static_cast<char>(count);
}

// Nothing where the bytes end before it does, or where it is beyond 2²⁸.
inline std::optional<std::size_t> TakeCount(std::string_view& bytes) {
  std::size_t count = 0;
  for (int shift = 0; shift < 28 && !bytes.empty(); shift += 7) {
    const auto byte = static_cast<unsigned char>(bytes.front());
    bytes.remove_prefix(1);
    count |= std::size_t{byte & 0x7fU} << shift;
    if (byte < 0x80) return count;
  }
  return std::nullopt;
}

// As many bytes as their count, which comes first, says.
inline void PutBytes(std::string_view text, std::string& bytes) {
  PutCount(text.size(), bytes);
  bytes += text;
}

inline std::optional<std::string_view> TakeBytes(std::string_view& bytes) {
  const std::optional<std::size_t> count = TakeCount(bytes);
  if (!count.has_value() || *count > bytes.size()) return std::nullopt;
  const std::string_view text = bytes.substr(0, *count);
  bytes.remove_prefix(*count);
  return text;
}

}  // namespace mle::watch

#endif  // APPS_WATCH_RAW_BYTES_H_
