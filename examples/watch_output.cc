// Says whether the model of one output still holds, by windows around the set-
// point changes of all outputs:
// watch_output MODEL.json RECORD.csv OUTPUT

#include <cstdio>
#include <string>
#include <vector>

#include "mle/maintain/select_output.h"
#include "mle/mle.h"

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto model = mle::ReadProcessModel(argv[1]);
  if (!model.ok()) return 2;
  const auto data = mle::LoadRecords({argv[2]}, *model, {}, {});
  if (!data.ok()) return 2;
  for (int i = 0; i < model->num_outputs(); ++i) {
    if (model->outputs()[i].name != argv[3]) continue;
    std::vector<mle::Record> windows;
    for (const mle::Record& window : data->Records()) {
      windows.push_back(mle::SelectOutput(window, i));
    }
    mle::CorrectOptions options;
    options.estimation.estimator = mle::Estimator::kOutputError;
    const auto result = mle::CorrectFromData(
        mle::SelectOutput(*model, i), mle::UseAsWindows(windows), options);
    if (!result.ok()) {
      std::fprintf(stderr, "%s\n",
                   std::string(result.status().message()).c_str());
      return 2;
    }
    std::printf("%s: %s, p = %.3g for no change\n", argv[3],
                std::string(mle::NameOf(result->decision)).c_str(),
                mle::PValue(*result));
    return 0;
  }
  std::fprintf(stderr, "the model has no output '%s'\n", argv[3]);
  return 2;
}
