// The style sheet of the pages that HtmlPage builds.

#ifndef APPS_REPORT_PAGE_STYLE_H_
#define APPS_REPORT_PAGE_STYLE_H_

#include <string_view>

namespace mle::report {

std::string_view PageStyle();

}  // namespace mle::report

#endif  // APPS_REPORT_PAGE_STYLE_H_
