// The last of the headers that are compiled once for the tests: what follows it,
// bodies of tests, runs once and is not worth optimising. The templates of the
// headers before it are optimised still.
#ifdef __clang__
#pragma clang optimize off
#endif
