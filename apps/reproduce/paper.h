// What the paper reports of its two cases, from one run each.

#ifndef APPS_REPRODUCE_PAPER_H_
#define APPS_REPRODUCE_PAPER_H_

#include <array>
#include <string_view>

namespace mle::reproduce {

// Output and input counted from 0.
struct PaperFigure {
  std::string_view case_name;
  int output;
  int input;
  // Magnitude of the error of the static gain, read from the step response.
  double gain_error;
  // Dead time read at the peak of the impulse response, in min; 0: not given.
  double delay;
};

inline constexpr std::array<PaperFigure, 4> kPaperFigures = {{
    {"gain", 0, 0, 9.33e-2, 0.0},
    {"gain", 1, 0, 5.15e-2, 0.0},
    {"delay", 0, 1, 0.0, 7.6},
    {"delay", 1, 1, 0.0, 7.6},
}};

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_PAPER_H_
