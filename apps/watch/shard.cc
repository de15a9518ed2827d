#include "apps/watch/shard.h"

#include <cstdint>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "apps/common/sha256.h"

namespace mle::watch {
namespace {

constexpr int kMostShards = 100'000;
constexpr std::size_t kHexDigits = 12;

}  // namespace

bool Shard::Has(std::string_view controller) const {
  const std::string hash =
      Sha256Of(std::string(controller)).substr(0, kHexDigits);
  std::uint64_t value = 0;
  if (!absl::SimpleHexAtoi(hash, &value)) return false;
  return value % static_cast<std::uint64_t>(count) ==
         static_cast<std::uint64_t>(number - 1);
}

std::string Shard::Name() const { return absl::StrCat(number, "-of-", count); }

absl::StatusOr<Shard> ParseShard(const std::string& text) {
  Shard shard;
  if (text.empty()) return shard;
  const std::vector<std::string> parts = absl::StrSplit(text, '/');
  if (parts.size() != 2 || !absl::SimpleAtoi(parts[0], &shard.number) ||
      !absl::SimpleAtoi(parts[1], &shard.count) || shard.number < 1 ||
      shard.count > kMostShards || shard.number > shard.count) {
    return absl::InvalidArgumentError(absl::StrCat(
        "it must be a number and how many there are, such as 3/16; "
        "at most ",
        kMostShards, " parts"));
  }
  shard.text = absl::StrCat(shard.number, "/", shard.count);
  return shard;
}

}  // namespace mle::watch
