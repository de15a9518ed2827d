#include "mle/regression/kernels/kernels.h"

#include <cstdlib>
#include <string_view>

#include "glog/logging.h"
#include "mle/regression/kernels/instruction_sets.h"

namespace mle {
namespace {

#define MLE_KERNELS(set)                                                      \
  Kernels {                                                                   \
#set, set::AddProducts, set::MultiplyColumns, set::SubtractColumnsTwice,  \
        set::SolveTransposed, set::Solve, set::FilterRows, set::RunFirstOrder \
  }

Kernels ChooseKernels() {
  const std::vector<Kernels> available = AvailableKernels();
  const char* wanted = std::getenv("MLE_INSTRUCTION_SET");
  if (wanted == nullptr || *wanted == '\0') return available.back();
  for (const Kernels& kernels : available) {
    if (std::string_view(wanted) == kernels.instruction_set) return kernels;
  }
  LOG(WARNING) << "MLE_INSTRUCTION_SET is \"" << wanted
               << "\", which this program or processor does not have; taking \""
               << available.back().instruction_set << "\"";
  return available.back();
}

}  // namespace

std::vector<Kernels> AvailableKernels() {
  std::vector<Kernels> available = {MLE_KERNELS(baseline)};
#ifdef MLE_KERNELS_X86
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    available.push_back(MLE_KERNELS(avx2));
    if (__builtin_cpu_supports("avx512f")) {
      available.push_back(MLE_KERNELS(avx512));
    }
  }
#endif
  return available;
}

const Kernels& VectorKernels() {
  static const Kernels kChosen = ChooseKernels();
  return kChosen;
}

}  // namespace mle
