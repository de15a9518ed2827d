#include "apps/watch/state_checksum.h"

#include <cstdint>
#include <string_view>

#include "apps/common/sha256.h"
#include "apps/watch/codec.h"

namespace mle::watch {
namespace {

// Every part with its length, so that no two lists of parts are the same bytes.
class Hash {
 public:
  Hash& Add(std::string_view text) {
    AddRaw(text.size());
    hash_.Add(text);
    return *this;
  }
  Hash& Add(std::int64_t value) { return AddRaw(value); }
  Hash& Add(double value) { return AddRaw(value); }
  std::string HexDigest() { return hash_.HexDigest(); }

 private:
  template <typename T>
  Hash& AddRaw(T value) {
    hash_.Add({reinterpret_cast<const char*>(&value), sizeof(value)});
    return *this;
  }

  Sha256 hash_;
};

void AddFilesAndDays(const Watch& watch, Hash& hash) {
  for (const auto& [path, file] : watch.files) {
    hash.Add(path).Add(file.bytes).Add(file.changed);
    hash.Add(file.first).Add(file.last).Add(file.fault);
  }
  for (const auto& [number, day] : watch.days) {
    hash.Add(std::int64_t{number}).Add(day.checksum);
    hash.Add(static_cast<std::int64_t>(day.state)).Add(day.reason);
  }
}

void AddScores(const Watch& watch, const BatchEncoder& encode, Hash& hash) {
  for (std::size_t i = 0; i < watch.outputs.size(); ++i) {
    for (const auto& [number, stored] : watch.outputs[i]) {
      hash.Add(static_cast<std::int64_t>(i)).Add(std::int64_t{number});
      hash.Add(std::int64_t{stored.batch.length}).Add(encode(i, stored));
    }
  }
}

}  // namespace

std::string ChecksumOf(const Watch& watch) {
  return ChecksumOf(watch,
                    [](std::size_t /*output*/, const StoredBatch& stored) {
                      return EncodeBatch(stored);
                    });
}

std::string ChecksumOf(const Watch& watch, const BatchEncoder& encode) {
  Hash hash;
  hash.Add(watch.controller).Add(watch.basis);
  hash.Add(std::int64_t{watch.begin}).Add(std::int64_t{watch.first});
  hash.Add(watch.sample_time);
  if (watch.reference.has_value()) hash.Add(EncodeReference(*watch.reference));
  AddFilesAndDays(watch, hash);
  AddScores(watch, encode, hash);
  for (const Alarm& alarm : watch.alarms) {
    hash.Add(alarm.id).Add(std::int64_t{alarm.output});
    hash.Add(std::int64_t{alarm.element}).Add(std::int64_t{alarm.day});
    hash.Add(std::int64_t{alarm.began}).Add(alarm.text);
  }
  for (const Proposal& proposal : watch.proposals) {
    hash.Add(std::int64_t{proposal.day}).Add(proposal.folder);
    hash.Add(proposal.decision).Add(proposal.conclusion);
  }
  return hash.HexDigest();
}

}  // namespace mle::watch
