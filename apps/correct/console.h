// Text that mle_correct prints.

#ifndef APPS_CORRECT_CONSOLE_H_
#define APPS_CORRECT_CONSOLE_H_

#include <vector>

#include "apps/correct/result.h"

namespace mle::correct {

// The records alone, for --dry_run.
void PrintData(const RecordData& data, const std::vector<DataFile>& files,
               const ProcessModel& model);

// On standard error: the most memory that the process has used so far.
void PrintMemory();

// "kind: text", on standard error.
void PrintMessages(const char* kind, const std::vector<Message>& messages);

// The verdict in at most six lines; with --verbose also what it rests on, and
// the warnings.
void PrintResult(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_CONSOLE_H_
