#include "apps/watch/codec.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "absl/strings/str_cat.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little,
              "the state is kept in little-endian order");

void Put(double value, std::string& bytes) {
  const auto kept = static_cast<float>(value);
  char raw[sizeof(kept)];
  std::memcpy(raw, &kept, sizeof(kept));
  bytes.append(raw, sizeof(kept));
}

std::size_t SizeFor(std::size_t n) {
  return sizeof(float) * (n + n * (n + 1) / 2 + 1 + n / 3);
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
  const Eigen::VectorXd& score = batch.batch.score;
  std::string bytes(1, static_cast<char>(score.size()));
  for (const double value : score) Put(value, bytes);
  for (Eigen::Index r = 0; r < score.size(); ++r) {
    for (Eigen::Index c = 0; c <= r; ++c) {
      Put(batch.batch.information(r, c), bytes);
    }
  }
  Put(batch.evidence.log_output, bytes);
  for (const double value : batch.evidence.log_elements) Put(value, bytes);
  return bytes;
}

absl::StatusOr<StoredBatch> DecodeBatch(std::string_view bytes) {
  const std::size_t n =
      bytes.empty() ? 0 : static_cast<unsigned char>(bytes.front());
  if (n == 0 || n % 3 != 0 || bytes.size() != 1 + SizeFor(n)) {
    return absl::DataLossError(
        absl::StrCat("the scores of a day have ", bytes.size(),
                     " bytes, which are not those of ", n, " parameters"));
  }
  bytes.remove_prefix(1);
  const auto take = [&bytes] {
    float value = 0.0F;
    std::memcpy(&value, bytes.data(), sizeof(value));
    bytes.remove_prefix(sizeof(value));
    return static_cast<double>(value);
  };
  const auto size = static_cast<Eigen::Index>(n);
  StoredBatch stored;
  stored.batch.score.resize(size);
  stored.batch.information.resize(size, size);
  for (double& value : stored.batch.score) value = take();
  for (Eigen::Index r = 0; r < size; ++r) {
    for (Eigen::Index c = 0; c <= r; ++c) {
      stored.batch.information(r, c) = stored.batch.information(c, r) = take();
    }
  }
  stored.evidence.log_output = take();
  for (std::size_t e = 0; e < n / 3; ++e) {
    stored.evidence.log_elements.push_back(take());
  }
  return stored;
}

BatchOutput AsKept(BatchOutput scores) {
  scores.score = scores.score.cast<float>().cast<double>();
  scores.information = scores.information.cast<float>().cast<double>();
  return scores;
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
  return Json({{"outputs", outputs},
               {"low", ListOf(reference.low)},
               {"high", ListOf(reference.high)}})
      .dump();
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
    reference.low = VectorOf(parsed.at("low"));
    reference.high = VectorOf(parsed.at("high"));
    return reference;
  } catch (const Json::exception&) {
    return absl::DataLossError("its reference cannot be read");
  }
}

}  // namespace mle::watch
