// The style sheet and the script of the pages that HtmlPage builds.

#ifndef APPS_REPORT_PAGE_STYLE_H_
#define APPS_REPORT_PAGE_STYLE_H_

#include <string_view>

namespace mle::report {

// Shows, below a figure, the values of its curves where the pointer is. It
// reads them back from the picture (svg.h), so they are as exact as that: three
// digits. Where an axis has dates, the place is one.
std::string_view ReadoutScript();

std::string_view PageStyle();

}  // namespace mle::report

#endif  // APPS_REPORT_PAGE_STYLE_H_
