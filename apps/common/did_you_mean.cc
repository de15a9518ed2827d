#include "apps/common/did_you_mean.h"

#include "mle/data/nearest_names.h"

namespace mle {
namespace {

// A second name is worth showing where it is about as near as the first.
constexpr int kAlike = 2;

}  // namespace

std::string DidYouMean(std::string_view given,
                       const std::vector<std::string>& known) {
  if (given.empty()) return "";
  const std::vector<std::string> near = NearestNames(given, known, 2);
  if (near.empty()) return "";
  std::string text = "did you mean '" + near[0] + "'";
  const auto distance = [&](std::size_t k) {
    return NameDistance(given, near[k]);
  };
  if (near.size() > 1 && distance(1) <= distance(0) + kAlike)
    text += " or '" + near[1] + "'";
  return text + "? ";
}

}  // namespace mle
