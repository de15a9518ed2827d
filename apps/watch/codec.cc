#include "apps/watch/codec.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "apps/watch/packed_score.h"
#include "apps/watch/raw_bytes.h"
#include "mle/base/status.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

using Json = nlohmann::ordered_json;

// Flags of a batch.
constexpr unsigned kUnpacked = 1;
constexpr unsigned kHasLargest = 2;

constexpr int kDaysInBlock = 64;

// Of ln E, and what is kept of it in these steps.
constexpr double kEvidenceSteps = 100.0;
constexpr double kMostEvidence = 1e8;
// What is kept already stays.
constexpr double kRounding = 1e-9;
// Of covariances.
constexpr double kCovarianceSteps = 1e6;

absl::Status DamagedScores() {
  return absl::DataLossError("the scores of a day cannot be read");
}

std::size_t UnpackedSize(std::size_t n) {
  return sizeof(float) * (n + n * (n + 1) / 2);
}

// In single precision: score, and the lower triangle of the information row by
// row.
void PutPart(const ScorePart& part, std::string& bytes) {
  for (const double value : part.score) {
    PutRaw(static_cast<float>(value), bytes);
  }
  for (Eigen::Index r = 0; r < part.score.size(); ++r) {
    for (Eigen::Index c = 0; c <= r; ++c) {
      PutRaw(static_cast<float>(part.information(r, c)), bytes);
    }
  }
}

ScorePart TakePart(std::size_t n, std::string_view bytes) {
  const auto size = static_cast<Eigen::Index>(n);
  ScorePart part = {Eigen::VectorXd(size), Eigen::MatrixXd(size, size)};
  for (double& value : part.score) value = TakeRaw<float>(bytes);
  for (Eigen::Index r = 0; r < size; ++r) {
    for (Eigen::Index c = 0; c <= r; ++c) {
      part.information(r, c) = part.information(c, r) = TakeRaw<float>(bytes);
    }
  }
  return part;
}

// Of what AsKept() has rounded: a count, odd for those below zero.
void PutEvidence(double value, std::string& bytes) {
  const auto steps = static_cast<std::int64_t>(std::llround(
      std::clamp(value * kEvidenceSteps, -kMostEvidence, kMostEvidence)));
  PutCount(static_cast<std::size_t>(steps < 0 ? -2 * steps - 1 : 2 * steps),
           bytes);
}

std::optional<double> TakeEvidence(std::string_view& bytes) {
  const std::optional<std::size_t> count = TakeCount(bytes);
  if (!count.has_value()) return std::nullopt;
  const auto half = static_cast<double>((*count + 1) / 2);
  return (*count % 2 == 0 ? half : -half) / kEvidenceSteps;
}

ScorePart Packed(const ScorePart& part) {
  std::string bytes;
  Pack(part, bytes);
  return Unpack(static_cast<std::size_t>(part.score.size()), bytes);
}

// Whether packing loses nothing.
bool IsPacked(const ScorePart& part) {
  const ScorePart packed = Packed(part);
  return packed.score == part.score && packed.information == part.information;
}

Json ListOf(const Eigen::VectorXd& values) {
  return std::vector<double>(values.begin(), values.end());
}

Eigen::VectorXd VectorOf(const Json& list) {
  const auto values = list.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(
      values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

std::string EncodeBatch(const StoredBatch& batch) {
  const ScoredBatch& scores = batch.batch;
  const ScorePart all = {scores.score, scores.information};
  const bool packed = IsPacked(all) && (!scores.largest.has_value() ||
                                        IsPacked(*scores.largest));
  std::string bytes;
  PutCount(static_cast<std::size_t>(scores.score.size()), bytes);
  PutCount(
      (packed ? 0 : kUnpacked) | (scores.largest.has_value() ? kHasLargest : 0),
      bytes);
  const auto put = packed ? Pack : PutPart;
  if (scores.largest.has_value()) put(*scores.largest, bytes);
  put(all, bytes);
  PutEvidence(batch.evidence.log_output, bytes);
  for (const double value : batch.evidence.log_elements) {
    PutEvidence(value, bytes);
  }
  return bytes;
}

absl::StatusOr<StoredBatch> TakeBatch(std::string_view& bytes) {
  const std::size_t n = TakeCount(bytes).value_or(0);
  const std::size_t flags = TakeCount(bytes).value_or(~std::size_t{0});
  if (n == 0 || n % 3 != 0 || n > bytes.size() ||
      flags > (kUnpacked | kHasLargest)) {
    return DamagedScores();
  }
  const bool unpacked = (flags & kUnpacked) != 0;
  const bool has_largest = (flags & kHasLargest) != 0;
  const std::size_t part = unpacked ? UnpackedSize(n) : PackedSize(n);
  if (bytes.size() < (has_largest ? 2 : 1) * part) return DamagedScores();
  const auto take = [&bytes, n, part, unpacked] {
    const std::string_view front = bytes.substr(0, part);
    bytes.remove_prefix(part);
    return unpacked ? TakePart(n, front) : Unpack(n, front);
  };
  StoredBatch stored;
  if (has_largest) stored.batch.largest = take();
  ScorePart all = take();
  stored.batch.score = std::move(all.score);
  stored.batch.information = std::move(all.information);
  for (std::size_t e = 0; e < 1 + n / 3; ++e) {
    const std::optional<double> evidence = TakeEvidence(bytes);
    if (!evidence.has_value()) return DamagedScores();
    if (e == 0) {
      stored.evidence.log_output = *evidence;
    } else {
      stored.evidence.log_elements.push_back(*evidence);
    }
  }
  if (!IsSound(stored)) return DamagedScores();
  return stored;
}

bool IsSound(const StoredBatch& batch) {
  const std::optional<ScorePart>& largest = batch.batch.largest;
  const std::vector<double>& elements = batch.evidence.log_elements;
  return batch.batch.score.allFinite() && batch.batch.information.allFinite() &&
         (!largest.has_value() ||
          (largest->score.allFinite() && largest->information.allFinite())) &&
         !std::isnan(batch.evidence.log_output) &&
         std::none_of(elements.begin(), elements.end(),
                      [](double value) { return std::isnan(value); });
}

std::string EncodeScores(const Watch& watch, int number) {
  std::string bytes;
  bool any = false;
  for (const std::map<int, StoredBatch>& output : watch.outputs) {
    const auto found = output.find(number);
    if (found == output.end()) {
      PutCount(0, bytes);
      continue;
    }
    any = true;
    PutCount(static_cast<std::size_t>(found->second.batch.length), bytes);
    bytes += EncodeBatch(found->second);
  }
  return any ? bytes : "";
}

absl::Status DecodeScores(std::string_view bytes, int number, Watch& watch) {
  for (std::size_t output = 0; !bytes.empty(); ++output) {
    const std::optional<std::size_t> length = TakeCount(bytes);
    if (!length.has_value()) return DamagedScores();
    if (output >= watch.outputs.size()) watch.outputs.resize(output + 1);
    if (*length == 0) continue;
    MLE_ASSIGN_OR_RETURN(StoredBatch stored, TakeBatch(bytes));
    stored.batch.number = number;
    stored.batch.length = static_cast<int>(*length);
    stored.evidence.number = number + stored.batch.length - 1;
    watch.outputs[output][number] = std::move(stored);
  }
  return absl::OkStatus();
}

int BlockOf(int day) {
  return day >= 0 ? day / kDaysInBlock
                  : -((kDaysInBlock - 1 - day) / kDaysInBlock);
}

std::string EncodeDays(const Watch& watch, int block) {
  std::string bytes;
  const int first = block * kDaysInBlock;
  for (auto day = watch.days.lower_bound(first);
       day != watch.days.end() && day->first < first + kDaysInBlock; ++day) {
    PutCount(static_cast<std::size_t>(day->first - first), bytes);
    PutCount(static_cast<std::size_t>(day->second.state), bytes);
    PutBytes(day->second.checksum, bytes);
    PutBytes(day->second.reason, bytes);
  }
  return bytes;
}

absl::Status DecodeDays(std::string_view bytes, int block, Watch& watch) {
  while (!bytes.empty()) {
    const std::size_t place = TakeCount(bytes).value_or(kDaysInBlock);
    const std::optional<std::size_t> state = TakeCount(bytes);
    const std::optional<std::string_view> checksum = TakeBytes(bytes);
    const std::optional<std::string_view> reason = TakeBytes(bytes);
    if (place >= kDaysInBlock || !state.has_value() ||
        *state > static_cast<std::size_t>(BatchState::kCannotTell) ||
        !checksum.has_value() || !reason.has_value()) {
      return absl::DataLossError("its days cannot be read");
    }
    watch.days[block * kDaysInBlock + static_cast<int>(place)] = {
        .checksum = std::string(*checksum),
        .state = static_cast<BatchState>(*state),
        .reason = std::string(*reason)};
  }
  return absl::OkStatus();
}

void RoundAsKept(ScoredBatch& batch) {
  std::vector<ScorePart> parts = {{batch.score, batch.information}};
  if (batch.largest.has_value()) parts.push_back(*batch.largest);
  std::vector<ScorePart> kept = parts;
  for (ScorePart& part : kept) part = Packed(part);
  if (!std::all_of(kept.begin(), kept.end(), IsPacked)) {
    kept = parts;
    for (ScorePart& part : kept) {
      part.score = part.score.cast<float>().cast<double>();
      part.information = part.information.cast<float>().cast<double>();
    }
  }
  batch.score = std::move(kept[0].score);
  batch.information = std::move(kept[0].information);
  if (batch.largest.has_value()) batch.largest = std::move(kept[1]);
}

ChangeEvidence AsKept(ChangeEvidence evidence) {
  const auto kept = [](double value) {
    return std::clamp(std::floor(value * kEvidenceSteps + kRounding),
                      -kMostEvidence, kMostEvidence) /
           kEvidenceSteps;
  };
  evidence.log_output = kept(evidence.log_output);
  for (double& value : evidence.log_elements) value = kept(value);
  return evidence;
}

void RoundAsKept(WatchReference& reference) {
  for (OutputReference& output : reference.outputs) {
    for (double& value : output.covariances) {
      value = std::round(value * kCovarianceSteps) / kCovarianceSteps;
    }
  }
}

std::string EncodeReference(const WatchReference& reference) {
  Json outputs = Json::array();
  for (const OutputReference& output : reference.outputs) {
    const NoiseEstimate& noise = output.noise;
    outputs.push_back({{"variance", noise.variance},
                       {"ratio", noise.ratio},
                       {"offset", noise.offset},
                       {"colour_ratio", noise.colour_ratio},
                       {"colour_pole", noise.colour_pole},
                       {"colour_damping", noise.colour_damping},
                       {"deviation", output.deviation},
                       {"covariances", output.covariances}});
  }
  Json json = {{"outputs", outputs},
               {"low", ListOf(reference.low)},
               {"high", ListOf(reference.high)}};
  // Earlier programs did not keep it.
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
      output.noise.colour_ratio = from.at("colour_ratio").get<double>();
      output.noise.colour_pole = from.at("colour_pole").get<double>();
      output.noise.colour_damping = from.at("colour_damping").get<double>();
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

}  // namespace mle::watch
