// SHA-256 (FIPS 180-4), to identify the input files of a result.
//
//   Sha256 hash;
//   hash.Add("abc");
//   hash.HexDigest();   // "ba7816bf…", 64 digits; empty if libcrypto failed

#ifndef APPS_COMMON_SHA256_H_
#define APPS_COMMON_SHA256_H_

#include <memory>
#include <string>
#include <string_view>

namespace mle {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Add(std::string_view bytes);
  // Ends the hash: nothing can be added afterwards.
  std::string HexDigest();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The SHA-256 of one text, in hexadecimal digits.
std::string Sha256Of(std::string_view bytes);

}  // namespace mle

#endif  // APPS_COMMON_SHA256_H_
