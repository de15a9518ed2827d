// What the studies have in common on their command lines.

#ifndef BENCHMARKS_STUDY_THREADS_H_
#define BENCHMARKS_STUDY_THREADS_H_

namespace mle::benchmarks {

// Takes --threads=N (N ≥ 1), wherever it stands, out of the arguments; without
// it 0, one for each processor (ParallelFor()). −1 if N is not such a number.
int TakeThreads(int& argc, char** argv);

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_STUDY_THREADS_H_
