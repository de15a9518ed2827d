// Numbers as the state keeps them: their bytes, little-endian, one after the
// other.

#ifndef APPS_WATCH_RAW_BYTES_H_
#define APPS_WATCH_RAW_BYTES_H_

#include <bit>
#include <cstring>
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

}  // namespace mle::watch

#endif  // APPS_WATCH_RAW_BYTES_H_
