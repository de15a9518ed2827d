// A transform as a line above a table (CSV): its channel, its kind, and keys
// with their numbers (docs/formats.md). Internal to mle/exchange.
//
//   transform,steam,equal_percentage,rangeability,50,closed,0,open,100,at,40
//   transform,level,piecewise_linear,point,0,0,point,20,5,point,60,45,at,30

#ifndef MLE_EXCHANGE_TRANSFORM_LINE_H_
#define MLE_EXCHANGE_TRANSFORM_LINE_H_

#include <string>

#include "absl/status/statusor.h"
#include "mle/exchange/model_table.h"
#include "mle/model/transform.h"

namespace mle {

// Of a line whose first field is "transform"; errors name line and column.
absl::StatusOr<Transform> ReadTransformLine(const ModelTable& table,
                                            const TableLine& line);

// The line, its end included; empty without a transform.
std::string FormatTransformLine(const std::string& channel,
                                const Transform& transform);

}  // namespace mle

#endif  // MLE_EXCHANGE_TRANSFORM_LINE_H_
