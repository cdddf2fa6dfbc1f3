/* brief.h: how much a long test does in builds in which steps are slow.
 *
 * Sanitizers and coverage look at what the code does, and steps without end that all do the same show them nothing
 * new; what the numbers say is tested in the release build. CMake defines SLIPDISK_BRIEF for these builds.
 */
#ifndef TESTS_BRIEF_H
#define TESTS_BRIEF_H

#ifdef SLIPDISK_BRIEF
#define BRIEF(full, brief) (brief)
#else
#define BRIEF(full, brief) (full)
#endif

#endif
