// The script of a page with figures.

#ifndef APPS_REPORT_READOUT_H_
#define APPS_REPORT_READOUT_H_

#include <string_view>

namespace mle::report {

// Shows, below a figure, the values of its curves where the pointer is. It
// reads them back from the picture (svg.h), so they are as exact as that: three
// digits. Where an axis has dates, the place is one.
std::string_view ReadoutScript();

}  // namespace mle::report

#endif  // APPS_REPORT_READOUT_H_
