// Lets a long command stop in order: it asks between its parts whether it
// should.
//
//   CatchStopSignals();
//   RunCampaign(campaign, StopRequested);

#ifndef APPS_COMMON_STOP_SIGNAL_H_
#define APPS_COMMON_STOP_SIGNAL_H_

namespace mle {

// From now on SIGINT, SIGTERM and SIGHUP only ask to stop. A second one ends
// the program at once.
void CatchStopSignals();

// From any thread.
bool StopRequested();

}  // namespace mle

#endif  // APPS_COMMON_STOP_SIGNAL_H_
