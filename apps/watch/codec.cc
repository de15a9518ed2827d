#include "apps/watch/codec.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/watch/packed_score.h"
#include "apps/watch/raw_bytes.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

using Json = nlohmann::ordered_json;

// What scores begin with.
constexpr char kPacked = 0;
constexpr char kUnpacked = 1;

absl::Status DamagedScores(std::size_t bytes, std::size_t n) {
  return absl::DataLossError(absl::StrCat("the scores of a day have ", bytes,
                                          " bytes, which are not those of ", n,
                                          " parameters"));
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
  std::string bytes = {packed ? kPacked : kUnpacked,
                       static_cast<char>(scores.score.size()),
                       static_cast<char>(scores.largest.has_value())};
  const auto put = packed ? Pack : PutPart;
  if (scores.largest.has_value()) put(*scores.largest, bytes);
  put(all, bytes);
  PutRaw(static_cast<float>(batch.evidence.log_output), bytes);
  for (const double value : batch.evidence.log_elements) {
    PutRaw(static_cast<float>(value), bytes);
  }
  return bytes;
}

absl::StatusOr<StoredBatch> DecodeBatch(std::string_view bytes) {
  const std::size_t given = bytes.size();
  // Until version 3 of the state n came first, and nothing was packed.
  const bool old =
      !bytes.empty() && bytes.front() != kPacked && bytes.front() != kUnpacked;
  const std::size_t header = old ? 1 : 3;
  if (given < header) return DamagedScores(given, 0);
  const bool packed = bytes.front() == kPacked;
  const std::size_t n = static_cast<unsigned char>(bytes[old ? 0 : 1]);
  const bool has_largest = !old && bytes[2] != 0;
  const std::size_t part = packed ? PackedSize(n) : UnpackedSize(n);
  if (n == 0 || n % 3 != 0 ||
      given !=
          header + (has_largest ? 2 : 1) * part + sizeof(float) * (1 + n / 3)) {
    return DamagedScores(given, n);
  }
  bytes.remove_prefix(header);
  const auto take = packed ? Unpack : TakePart;
  StoredBatch stored;
  if (has_largest) {
    stored.batch.largest = take(n, bytes.substr(0, part));
    bytes.remove_prefix(part);
  }
  ScorePart all = take(n, bytes.substr(0, part));
  bytes.remove_prefix(part);
  stored.batch.score = std::move(all.score);
  stored.batch.information = std::move(all.information);
  stored.evidence.log_output = TakeRaw<float>(bytes);
  for (std::size_t e = 0; e < n / 3; ++e) {
    stored.evidence.log_elements.push_back(TakeRaw<float>(bytes));
  }
  return stored;
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
  evidence.log_output = static_cast<float>(evidence.log_output);
  for (double& value : evidence.log_elements) value = static_cast<float>(value);
  return evidence;
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
