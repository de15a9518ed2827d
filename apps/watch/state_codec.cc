// How scores and references are kept in the state, and its checksum.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "apps/common/sha256.h"
#include "apps/watch/state.h"
#include "mle/monitor/model_watch.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little,
              "the state is kept in little-endian order");

void Put(const ScorePart& part, std::vector<double>& numbers) {
  numbers.insert(numbers.end(), part.score.begin(), part.score.end());
  for (Eigen::Index r = 0; r < part.score.size(); ++r) {
    for (Eigen::Index c = 0; c <= r; ++c) {
      numbers.push_back(part.information(r, c));
    }
  }
}

ScorePart Take(Eigen::Index n, const double*& at) {
  ScorePart part = {Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  for (double& value : part.score) value = *at++;
  for (Eigen::Index r = 0; r < n; ++r) {
    for (Eigen::Index c = 0; c <= r; ++c) {
      part.information(r, c) = part.information(c, r) = *at++;
    }
  }
  return part;
}

bool IsSound(const ScorePart& part) {
  return part.score.allFinite() && part.information.allFinite();
}

Json ListOf(const Eigen::VectorXd& values) {
  return std::vector<double>(values.begin(), values.end());
}

Eigen::VectorXd VectorOf(const Json& list) {
  const auto values = list.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(
      values.data(), static_cast<Eigen::Index>(values.size()));
}

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

}  // namespace

std::string EncodeBatch(const StoredBatch& stored) {
  const ScoredBatch& batch = stored.batch;
  std::vector<double> numbers = {static_cast<double>(batch.score.size()),
                                 batch.largest.has_value() ? 1.0 : 0.0};
  if (batch.largest.has_value()) Put(*batch.largest, numbers);
  Put({batch.score, batch.information}, numbers);
  numbers.push_back(stored.evidence.log_output);
  numbers.insert(numbers.end(), stored.evidence.log_elements.begin(),
                 stored.evidence.log_elements.end());
  return {reinterpret_cast<const char*>(numbers.data()),
          numbers.size() * sizeof(double)};
}

absl::StatusOr<StoredBatch> DecodeBatch(std::string_view bytes, int number,
                                        int length) {
  const auto damaged =
      absl::DataLossError("the scores of a day cannot be read");
  std::vector<double> numbers(bytes.size() / sizeof(double));
  if (numbers.size() < 2 || bytes.size() % sizeof(double) != 0) return damaged;
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  // Nothing is computed with what is not a small whole number.
  constexpr double kMostParameters = 1e5;
  const double size = numbers[0];
  const double parts = 1.0 + numbers[1];
  if (!(size > 0.0 && size <= kMostParameters) || std::fmod(size, 3.0) != 0.0 ||
      (parts != 1.0 && parts != 2.0) || number < 0 || length < 1 ||
      static_cast<double>(numbers.size()) !=
          3.0 + parts * (size + size * (size + 1.0) / 2.0) + size / 3.0) {
    return damaged;
  }
  const auto n = static_cast<Eigen::Index>(size);
  const double* at = numbers.data() + 2;
  StoredBatch stored;
  if (parts == 2.0) stored.batch.largest = Take(n, at);
  ScorePart all = Take(n, at);
  stored.evidence.log_output = *at++;
  stored.evidence.log_elements.assign(at, at + n / 3);
  if (!IsSound(all) ||
      (stored.batch.largest.has_value() && !IsSound(*stored.batch.largest)) ||
      std::isnan(stored.evidence.log_output) ||
      std::any_of(at, at + n / 3, [](double e) { return std::isnan(e); })) {
    return damaged;
  }
  stored.batch.number = number;
  stored.batch.length = length;
  stored.batch.score = std::move(all.score);
  stored.batch.information = std::move(all.information);
  stored.evidence.number = number + length - 1;
  return stored;
}

std::string EncodeReference(const WatchReference& reference) {
  Json outputs = Json::array();
  for (const OutputReference& output : reference.outputs) {
    const NoiseEstimate& noise = output.noise;
    outputs.push_back({{"variance", noise.variance},
                       {"ratio", noise.ratio},
                       {"offset", noise.offset},
                       {"colour_ratio", noise.ar_ratio},
                       {"colour_pole", noise.ar_pole},
                       {"colour_damping", noise.ar_damping},
                       {"deviation", output.deviation},
                       {"covariances", output.covariances}});
  }
  Json json = {{"outputs", outputs},
               {"low", ListOf(reference.low)},
               {"high", ListOf(reference.high)}};
  for (const OutputOperation& output : reference.operation) {
    json["operation"].push_back(
        {{"changes", output.changes},
         {"change_size", output.change_size},
         {"squared_error", output.squared_error.has_value()
                               ? Json(*output.squared_error)
                               : Json()}});
  }
  return json.dump();
}

absl::StatusOr<WatchReference> DecodeReference(const std::string& json) {
  // Written by this program alone: whatever else is found is damage.
  try {
    const Json parsed = Json::parse(json);
    WatchReference reference;
    for (const Json& from : parsed.at("outputs")) {
      OutputReference output;
      output.noise.variance = from.at("variance").get<double>();
      output.noise.ratio = from.at("ratio").get<double>();
      output.noise.offset = from.at("offset").get<bool>();
      output.noise.ar_ratio = from.at("colour_ratio").get<double>();
      output.noise.ar_pole = from.at("colour_pole").get<double>();
      output.noise.ar_damping = from.at("colour_damping").get<double>();
      output.deviation = from.at("deviation").get<double>();
      output.covariances = from.at("covariances").get<std::vector<double>>();
      reference.outputs.push_back(std::move(output));
    }
    if (parsed.contains("operation")) {
      for (const Json& from : parsed.at("operation")) {
        OutputOperation& output = reference.operation.emplace_back();
        output.changes = from.at("changes").get<double>();
        output.change_size = from.at("change_size").get<double>();
        if (const Json& square = from.at("squared_error"); !square.is_null()) {
          output.squared_error = square.get<double>();
        }
      }
    }
    reference.low = VectorOf(parsed.at("low"));
    reference.high = VectorOf(parsed.at("high"));
    return reference;
  } catch (const Json::exception&) {
    return absl::DataLossError("its reference cannot be read");
  }
}

std::string ChecksumOf(const Watch& watch) {
  Hash hash;
  hash.Add(watch.controller).Add(watch.basis);
  hash.Add(std::int64_t{watch.begin}).Add(std::int64_t{watch.first});
  hash.Add(watch.sample_time);
  if (watch.reference.has_value()) hash.Add(EncodeReference(*watch.reference));
  for (const auto& [path, file] : watch.files) {
    hash.Add(path).Add(file.bytes).Add(file.changed);
    hash.Add(file.first).Add(file.last).Add(file.fault);
  }
  for (const auto& [number, day] : watch.days) {
    hash.Add(std::int64_t{number}).Add(day.checksum);
    hash.Add(static_cast<std::int64_t>(day.state)).Add(day.reason);
  }
  for (std::size_t i = 0; i < watch.outputs.size(); ++i) {
    for (const auto& [number, stored] : watch.outputs[i]) {
      hash.Add(static_cast<std::int64_t>(i)).Add(std::int64_t{number});
      hash.Add(std::int64_t{stored.batch.length}).Add(EncodeBatch(stored));
    }
  }
  for (const Alarm& alarm : watch.alarms) {
    hash.Add(alarm.id).Add(std::int64_t{alarm.output});
    hash.Add(std::int64_t{alarm.element}).Add(std::int64_t{alarm.day});
    hash.Add(std::int64_t{alarm.began}).Add(alarm.text);
    hash.Add(static_cast<std::int64_t>(alarm.kind));
  }
  for (const Proposal& proposal : watch.proposals) {
    hash.Add(std::int64_t{proposal.day}).Add(proposal.folder);
    hash.Add(proposal.decision).Add(proposal.conclusion);
  }
  for (const Trial& trial : watch.trials) {
    hash.Add(std::int64_t{trial.day}).Add(std::int64_t{trial.last_day});
    hash.Add(trial.sample_time).Add(trial.in_use).Add(trial.proposed);
    hash.Add(trial.ended).Add(trial.fault);
    hash.Add(std::int64_t{trial.adopted_day}).Add(EncodeTrial(trial.state));
    if (trial.adopted.has_value()) {
      hash.Add(trial.adopted->who).Add(trial.adopted->at);
      hash.Add(trial.adopted->note);
    }
  }
  return hash.HexDigest();
}

}  // namespace mle::watch
