#include "apps/common/sha256.h"

#include <array>

#include "absl/strings/str_format.h"
#include "openssl/evp.h"

namespace mle {

struct Sha256::State {
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context{EVP_MD_CTX_new(),
                                                             &EVP_MD_CTX_free};
  bool good = false;
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  state_->good =
      state_->context != nullptr &&
      EVP_DigestInit_ex(state_->context.get(), EVP_sha256(), nullptr) == 1;
}

Sha256::~Sha256() = default;

void Sha256::Add(std::string_view bytes) {
  state_->good =
      state_->good &&
      EVP_DigestUpdate(state_->context.get(), bytes.data(), bytes.size()) == 1;
}

std::string Sha256::HexDigest() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  if (!state_->good ||
      EVP_DigestFinal_ex(state_->context.get(), digest.data(), &length) != 1) {
    return "";
  }
  state_->good = false;
  std::string text;
  for (unsigned int i = 0; i < length; ++i) {
    absl::StrAppendFormat(&text, "%02x", digest[i]);
  }
  return text;
}

std::string Sha256Of(std::string_view bytes) {
  Sha256 hash;
  hash.Add(bytes);
  return hash.HexDigest();
}

}  // namespace mle
