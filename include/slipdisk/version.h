/* version.h: the version of slipdisk, defined here alone; CMakeLists.txt reads it from this
 * file. */
#ifndef SLIPDISK_VERSION_H
#define SLIPDISK_VERSION_H

#define SD_VERSION_MAJOR 0
#define SD_VERSION_MINOR 6
#define SD_VERSION_PATCH 0
#define SD_VERSION "0.6.0"
/* day of the release, or of the last change since the release */
#define SD_VERSION_DATE "2026-11-27"
/* The version as one number that can be compared: 600 is 0.6.0. */
#define SD_VERSION_NUMBER (10000 * SD_VERSION_MAJOR + 100 * SD_VERSION_MINOR + SD_VERSION_PATCH)

#endif
