#include "mle/maintain/modes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "mle/base/absl_view.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/nearest_names.h"
#include "mle/data/record_columns.h"

namespace mle {
namespace {

enum class Mode { kNeither, kByHand, kByController, kAuto };

// The numbers that words are read as. The mean of two words, where a mode
// changes within a sample, is never the number of another.
constexpr double kNeitherCode = 5003.91;
constexpr double kByHandCode = 2000.37;
constexpr double kByControllerCode = 4007.13;
constexpr double kAutoCode = 3001.71;
constexpr double kLeastCode = 2000.0;
// Rows of modes may come on change only.
constexpr double kHeldSamples = 1000.0;

void AddWords(const std::string& words, double code,
              std::map<std::string, double>& codes) {
  const std::vector<std::string> all = absl::StrSplit(words, ' ');
  for (const std::string& word : all) codes[word] = code;
}

const std::map<std::string, double>& ModeWords() {
  static const auto* const kWords = [] {
    auto* const words = new std::map<std::string, double>;
    AddWords(
        "man manual m hand local l off shed standby warm false no disabled "
        "inactive",
        kByHandCode, *words);
    AddWords(
        "cas cascade c rcas rout bcas rsp remote r prd ddc on true yes optim "
        "active enabled",
        kByControllerCode, *words);
    AddWords("auto automatic aut a", kAutoCode, *words);
    AddWords("iman init trk track tracking lo oos o/s hold", kNeitherCode,
             *words);
    return words;
  }();
  return *kWords;
}

constexpr std::string_view kKnown =
    "choose from MAN, MANUAL, LOCAL, OFF, SHED, STANDBY, WARM and 0, CAS, "
    "RCAS, "
    "ROUT, BCAS, REMOTE, PRD, ON and 1, AUTO, IMAN, INIT, TRK, LO, OOS and "
    "HOLD";

struct Place {
  int input = ByHand::kNone;
  int output = ByHand::kNone;
};

absl::StatusOr<Place> PlaceOf(const ModeTag& tag, const ProcessModel& model) {
  if (tag.channel.empty()) return Place{ByHand::kAll, ByHand::kAll};
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.inputs()[j].name == tag.channel) return Place{j, ByHand::kNone};
  }
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (model.outputs()[i].name == tag.channel) return Place{ByHand::kNone, i};
  }
  return OptionError(
      "mode_tag",
      absl::StrCat("mode_tag = ", tag.tag, "=", tag.channel, ": '", tag.channel,
                   "' is not an input or output of the model"));
}

absl::StatusOr<Mode> ModeOf(double code) {
  if (!std::isfinite(code)) return Mode::kNeither;
  if (code == 0.0 || code == kByHandCode) return Mode::kByHand;
  if (code == 1.0 || code == kByControllerCode) return Mode::kByController;
  if (code == kAutoCode) return Mode::kAuto;
  if (code >= kLeastCode || (code > 0.0 && code < 1.0)) return Mode::kNeither;
  return absl::InvalidArgumentError(
      absl::StrCat(code, " is not a mode; ", AbslView(kKnown)));
}

// The tags as inputs of a model of the first output.
ProcessModel ModelOfModes(const ProcessModel& model,
                          const std::vector<ModeTag>& tags) {
  std::vector<InputChannel> inputs;
  for (std::size_t t = 0; t < tags.size(); ++t) {
    inputs.push_back({absl::StrCat("mode ", t + 1), ""});
  }
  return ProcessModel(model.name(), model.time_unit(), std::move(inputs),
                      {model.outputs().front()});
}

HistorianOptions OptionsOfModes(const HistorianOptions& options,
                                const ProcessModel& model,
                                const std::vector<ModeTag>& tags,
                                double sample_time) {
  HistorianOptions result = options;
  const std::string& output = model.outputs().front().name;
  result.columns.tags.clear();
  for (const TagMapping& tag : options.columns.tags) {
    if (tag.channel == output) result.columns.tags.push_back(tag);
  }
  // Set points of other outputs stand in the file, too.
  result.columns.unused_tags.clear();
  for (const OutputChannel& other : model.outputs()) {
    if (other.name != output) {
      result.columns.unused_tags.push_back(SetPointName(other.name));
    }
  }
  for (std::size_t t = 0; t < tags.size(); ++t) {
    result.columns.tags.push_back({tags[t].tag, absl::StrCat("mode ", t + 1)});
  }
  result.columns.ignore_other_columns = true;
  result.columns.word_values = ModeWords();
  result.sample_time = sample_time;
  result.max_gap = kHeldSamples * sample_time;
  result.progress = {};
  return result;
}

absl::Status OnWords(const absl::Status& status) {
  if (!absl::StrContains(OptionOf(status), "any_word_is_bad")) return status;
  const std::string text(status.message());
  return OptionError(
      "mode_tag",
      absl::StrCat(text.substr(0, text.find(" is not ")),
                   " is not a mode (mode_tag); ", AbslView(kKnown)));
}

// The time in each mode by one tag, sample by sample of the records.
struct Found {
  double by_hand = 0.0;  // times
  double by_controller = 0.0;
};

absl::StatusOr<Found> AddByHand(const std::vector<Record>& modes, int tag,
                                const Place& place,
                                std::vector<ByHand>& segments) {
  Found found;
  for (const Record& record : modes) {
    bool goes_on = false;
    for (int k = 0; k < record.samples(); ++k) {
      MLE_ASSIGN_OR_RETURN(const Mode mode, ModeOf(record.inputs(tag, k)));
      const bool of_input = place.input >= 0;
      const bool by_hand =
          mode == Mode::kByHand || (mode == Mode::kAuto && of_input);
      const bool by_controller =
          mode == Mode::kByController || (mode == Mode::kAuto && !of_input);
      (by_hand ? found.by_hand : found.by_controller) +=
          by_hand || by_controller ? record.sample_time : 0.0;
      if (by_hand && !goes_on) {
        segments.push_back(
            {record.time(k), record.time(k), place.input, place.output});
      }
      if (by_hand) segments.back().to = record.time(k);
      goes_on = by_hand;
    }
  }
  return found;
}

Message NoteOn(const ModeTag& tag, const Place& place, const Found& found,
               double all) {
  const auto share = [all](double time) {
    return absl::StrFormat("%.0f %%", 100.0 * std::min(time / all, 1.0));
  };
  std::string text = absl::StrCat(
      tag.tag, ": ",
      place.input >= 0
          ? absl::StrCat(tag.channel, " was moved by the controller")
      : place.output >= 0
          ? absl::StrCat("the loop of ", tag.channel, " was in use")
          : "the controller was in use",
      " for ", share(found.by_controller), " of the time, and by hand for ",
      share(found.by_hand));
  if (found.by_hand > 0.0 && place.input != ByHand::kNone) {
    text += ": moves by hand count as changes";
  }
  if (found.by_hand > 0.0 && place.output != ByHand::kNone) {
    absl::StrAppend(&text, place.input == ByHand::kNone ? ": " : ", and ",
                    "changes of set points then do not");
  }
  text += '.';
  return {MessageCode::kWindows, tag.channel, std::move(text), {"mode_tag"}};
}

}  // namespace

absl::StatusOr<double> ModeCode(std::string_view word) {
  const auto found = ModeWords().find(FoldedName(word));
  if (found != ModeWords().end()) return found->second;
  return OptionError("mode_tag", absl::StrCat("'", AbslView(word),
                                              "' is not a mode (mode_tag); ",
                                              AbslView(kKnown)));
}

absl::StatusOr<Modes> ReadModes(const ImportOf& import,
                                const ProcessModel& model,
                                const HistorianOptions& options,
                                const std::vector<ModeTag>& tags,
                                const std::vector<Record>& records) {
  std::vector<Place> places;
  for (const ModeTag& tag : tags) {
    MLE_ASSIGN_OR_RETURN(places.emplace_back(), PlaceOf(tag, model));
  }
  Modes modes;
  if (tags.empty() || records.empty()) return modes;
  const double sample_time = records.front().sample_time;
  const absl::StatusOr<HistorianImport> imported =
      import(ModelOfModes(model, tags),
             OptionsOfModes(options, model, tags, sample_time));
  if (!imported.ok()) return OnWords(imported.status());
  double all = 0.0;
  for (const Record& record : imported->records) {
    all += record.samples() * record.sample_time;
  }
  for (std::size_t t = 0; t < tags.size(); ++t) {
    const absl::StatusOr<Found> found = AddByHand(
        imported->records, static_cast<int>(t), places[t], modes.by_hand);
    if (!found.ok()) {
      return OptionError("mode_tag",
                         absl::StrCat("mode_tag = ", tags[t].tag, ": ",
                                      found.status().message()));
    }
    modes.notes.push_back(NoteOn(tags[t], places[t], *found, all));
  }
  return modes;
}

}  // namespace mle
