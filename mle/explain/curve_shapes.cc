#include "mle/explain/curve_shapes.h"

#include <algorithm>
#include <cstddef>

#include "mle/explain/curves.h"

namespace mle {
namespace {

void ChooseShape(const std::vector<OutputCompetition*>& outputs,
                 const Explanation& curve) {
  const std::vector<int> shapes = ShapesOf(curve.kind);
  std::vector<double> left;
  std::vector<std::vector<ExplanationFit>> fits(shapes.size());
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    left.push_back(ShapeCost(shapes[s]));
    for (const OutputCompetition* output : outputs) {
      const std::vector<Explanation> all = output->Explanations();
      const auto own = std::find_if(
          all.begin(), all.end(),
          [&](const Explanation& one) { return one.SameAs(curve); });
      fits[s].push_back(output->WithShapeOf(all, *own, shapes[s]));
      left[s] += fits[s].back().energy / output->unit();
    }
  }
  const auto best = static_cast<std::size_t>(
      std::min_element(left.begin(), left.end()) - left.begin());
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    std::vector<Explanation> alternatives;
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      if (s == best || !(left[s] <= left[best] + kAsMuch)) continue;
      for (const Explanation& one : fits[s][i].explanations) {
        if (one.SameAs(curve)) alternatives.push_back(one);
      }
    }
    outputs[i]->TakeShape(fits[best][i], curve, alternatives);
  }
}

}  // namespace

void ChooseShapes(
    const std::vector<std::unique_ptr<OutputCompetition>>& outputs) {
  std::vector<Explanation> done;
  for (const auto& first : outputs) {
    if (first == nullptr || first->together()) continue;
    for (const Explanation& curve : first->Explanations()) {
      if (!IsCurve(curve.kind) || Contains(done, curve)) continue;
      std::vector<OutputCompetition*> shown;
      for (const auto& output : outputs) {
        if (output != nullptr && !output->together() &&
            Contains(output->Explanations(), curve)) {
          shown.push_back(output.get());
        }
      }
      ChooseShape(shown, curve);
      done.push_back(curve);
    }
  }
}

}  // namespace mle
