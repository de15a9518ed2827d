// A model file of any form, MAT files among them, and its conversion to every
// other form: what is written is read again.

#include "mle/exchange/mat_file.h"
#include "mle/exchange/model_conversion.h"
#include "mle/exchange/model_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scratch_file.h"

namespace mle {
namespace {

// Beyond, models that are right take longer than an input may.
constexpr int kMostElements = 9;
constexpr int kMostOrder = 12;
constexpr std::size_t kMostCoefficients = 400;

bool IsSmall(const ModelFile& file) {
  int elements = 0;
  int order = 0;
  for (int i = 0; i < file.process.num_outputs(); ++i) {
    for (int j = 0; j < file.process.num_inputs(); ++j) {
      if (file.process.element(i, j).IsZero()) continue;
      ++elements;
      order +=
          static_cast<int>(file.process.element(i, j).denominator().size());
    }
  }
  std::size_t coefficients = 0;
  for (const PairResponse& pair : file.step_responses.pairs) {
    coefficients += static_cast<std::size_t>(pair.coefficients.size());
  }
  return elements <= kMostElements && order <= kMostOrder * elements &&
         coefficients <= kMostCoefficients;
}

void Convert(const ModelFile& file, ModelForm form, ModelFileType type,
             const fuzz::ScratchFolder& folder) {
  ModelConversion to;
  to.form = form;
  to.type = type;
  to.coefficients = 20;
  if (!to.Validate().ok()) return;
  const auto converted = ConvertModel(file, to);
  if (!converted.ok()) {
    FUZZ_EXPECT(!converted.status().message().empty());
    return;
  }
  const auto again = ReadModelFile(folder.Write("again", converted->text));
  FUZZ_EXPECT(again.ok(), again.status().ToString());
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const mle::fuzz::ScratchFolder folder;
  const std::string path = folder.Write("model", bytes.Rest());
  const auto file = mle::ReadModelFile(path);
  if (!file.ok()) {
    FUZZ_EXPECT(file.status().message().find(path) != std::string::npos,
                file.status().ToString());
    return 0;
  }
  FUZZ_EXPECT(file->process.Validate().ok(),
              file->process.Validate().ToString());
  if (!mle::IsSmall(*file)) return 0;
  for (const mle::ModelForm form :
       {mle::ModelForm::kTransferFunctions, mle::ModelForm::kElementTable,
        mle::ModelForm::kStepResponses,
        mle::ModelForm::kDiscreteTransferFunctions,
        mle::ModelForm::kStateSpace}) {
    for (const mle::ModelFileType type :
         {mle::ModelFileType::kJson, mle::ModelFileType::kCsv,
          mle::ModelFileType::kMat}) {
      mle::Convert(*file, form, type, folder);
    }
  }
  return 0;
}
