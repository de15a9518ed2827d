// The names of parameters that change, and how the size of a change is written.

#ifndef APPS_WATCH_CHANGE_TEXT_H_
#define APPS_WATCH_CHANGE_TEXT_H_

#include <string>

namespace mle::watch {

// Parameters of an element: 0 its gain, 1 its time constant, and this.
inline constexpr int kDeadTime = 2;

// "gain", "time constant", "dead time"; with underscores for programs.
const char* ParameterName(int parameter);
const char* ParameterKey(int parameter);

// "+0.42", "−1.90".
std::string Signed(double value, int decimals);

}  // namespace mle::watch

#endif  // APPS_WATCH_CHANGE_TEXT_H_
