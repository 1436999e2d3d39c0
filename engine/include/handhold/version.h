// Version of these headers, for C and C++. The library's own: handhold_version() of handhold.h, find_package, pkg-config.
#ifndef HANDHOLD_VERSION_H
#define HANDHOLD_VERSION_H

#define HANDHOLD_VERSION_MAJOR 0
#define HANDHOLD_VERSION_MINOR 1
#define HANDHOLD_VERSION_PATCH 0
#define HANDHOLD_VERSION_STRING "0.1.0"

#endif
