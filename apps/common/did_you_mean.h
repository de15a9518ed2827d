// Names that may have been meant, for messages about names that are not known.

#ifndef APPS_COMMON_DID_YOU_MEAN_H_
#define APPS_COMMON_DID_YOU_MEAN_H_

#include <string>
#include <string_view>
#include <vector>

namespace mle {

// "did you mean 'huber'? ", with a blank at the end; empty where none of
// `known` is near (mle/data/nearest_names.h).
std::string DidYouMean(std::string_view given,
                       const std::vector<std::string>& known);

}  // namespace mle

#endif  // APPS_COMMON_DID_YOU_MEAN_H_
