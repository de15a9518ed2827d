// Curves of outputs and inputs with one parameter, c in 1/unit, of slope 1 at
// x = 0:
//
//   exponential   h(x) = (e^{c x} − 1)/c          an equal-percentage valve
//   logarithm     h(x) = ln(1 + c x)/c            its inverse: compositions
//   quadratic     h(x) = x + c x²/2
//   root          h(x) = (√(1 + 2 c x) − 1)/c     its inverse: quick opening
//   sinh          h(x) = sinh(c x)/c, asinh(c x)/c where c < 0: pH
//   tanh          h(x) = tanh(c x)/c where c < 0, artanh(c x)/c where c > 0
//   kink          h(x) = x up to k, k + e^{c w} (x − k) beyond, k = ±0.05 w,
//                 ±0.25 w, ±0.5 w, ±0.75 w, w the largest |x| visited: two
//                 valves in split range
//
// To second order the first four are one, and sinh and tanh to third order:
// which it is is asked once a curve has won (curve_shapes.h).

#ifndef MLE_EXPLAIN_CURVES_H_
#define MLE_EXPLAIN_CURVES_H_

#include <vector>

#include "mle/explain/explanation.h"
#include "mle/model/transform.h"

namespace mle {

enum class CurveShape {
  kExponential,  // of each family the one that competes
  kSinh,
  kLogarithm,
  kQuadratic,
  kRoot,
  kTanh,
  kFirstKink,  // the others follow: kKinks of them
};
inline constexpr int kKinks = 8;

// Of a curved output or input (Explanation::part).
CurveShape ShapeOf(const Explanation& explanation);
// The shapes of a curve: an input has no S, an output no kink.
std::vector<int> ShapesOf(ExplanationKind kind);
// Those that compete, one of each family and, of kinks, side.
std::vector<int> CompetingShapes(ExplanationKind kind);
// The curve in another shape, from where it is to be estimated: alike to second
// (third) order, or, of the other family, bent either way.
std::vector<Explanation> InShape(Explanation curve, int part);

// M: what leaves no more than this beyond the best explains as much.
inline constexpr double kAsMuch = 3.0;

// What a shape has to leave less than others, in M: an S kAsMuch, since records
// that bend to one side tell little of it, and a kink, which may be anywhere.
double ShapeCost(int part);

// h as a transform that is 0 at 0: z of x is h(x). None for c = 0. `width` is
// w, > 0, of a kink.
Transform CurveTransform(CurveShape shape, double c, double width);

// A curve that was found: of an output y = a + h(z − a), of an input v =
// a + h(u − a), z and v what the model's elements are linear between.
struct FoundCurve {
  bool is_output = false;
  int channel = 0;
  CurveShape shape = CurveShape::kExponential;
  double curvature = 0.0;       // c
  double standard_error = 0.0;  // of c
  double evidence = 0.0;
  double at = 0.0;   // a: where the records began
  double low = 0.0;  // what they visited
  double high = 0.0;
  // Shapes that explain as much.
  struct Alternative {
    CurveShape shape = CurveShape::kExponential;
    double curvature = 0.0;
  };
  std::vector<Alternative> alternatives = {};
  // Curves that were found upon it, in what it makes of the channel.
  std::vector<FoundCurve> upon = {};

  // The transform of the channel, without those upon it.
  Transform AsTransform() const { return TransformIn(shape, curvature); }
  // The gain at a value (of an input that of its effects, of an output all of
  // its gains) relative to that at a, with its 95 % interval, in which those of
  // the alternatives are.
  struct Gain {
    double value = 1.0;
    double lower = 1.0;
    double upper = 1.0;
  };
  Gain GainAt(double value) const;

 private:
  // The transform with another shape and c.
  Transform TransformIn(CurveShape other, double c) const;
};

}  // namespace mle

#endif  // MLE_EXPLAIN_CURVES_H_
