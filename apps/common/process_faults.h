// Handling of system failures in a command: exhausted memory, no more threads,
// a full disk, which the command reports and ends with exit code 1; and of
// signals, which ask a long command to stop in order.

#ifndef APPS_COMMON_PROCESS_FAULTS_H_
#define APPS_COMMON_PROCESS_FAULTS_H_

namespace mle {

// - No memory, or no thread, ends the program with a message instead of a core
//   dump.
// - A stack of less than 1 MB is raised, or ends the program with a message.
// - A file beyond its limit of size (ulimit -f) is an error of that write, not
//   the end of the program.
// - Text on standard output that could not be written is an error, unless a
//   pipe's reader has gone: the command goes on and writes its files.
void PrepareForFaults();

// From now on SIGINT, SIGTERM and SIGHUP only ask to stop. A second one ends
// the program at once.
void CatchStopSignals();

// Asked between the parts of the work, from any thread.
bool StopRequested();

}  // namespace mle

#endif  // APPS_COMMON_PROCESS_FAULTS_H_
