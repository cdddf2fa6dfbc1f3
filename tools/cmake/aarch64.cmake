# Toolchain: Debian's cross compiler for aarch64; tools/arm.sh passes the folder with the unpacked libraries.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SLIPDISK_ARM_ROOT)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH ${SLIPDISK_ARM_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# where Debian has HDF5
set(CMAKE_LIBRARY_PATH /usr/lib/aarch64-linux-gnu/hdf5/serial)
set(CMAKE_INCLUDE_PATH /usr/include/hdf5/serial)
# libraries that the libraries need
set(CMAKE_EXE_LINKER_FLAGS_INIT "-Wl,-rpath-link,${SLIPDISK_ARM_ROOT}/usr/lib/aarch64-linux-gnu:${SLIPDISK_ARM_ROOT}/lib/aarch64-linux-gnu")
set(ENV{PKG_CONFIG_LIBDIR} ${SLIPDISK_ARM_ROOT}/usr/lib/aarch64-linux-gnu/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${SLIPDISK_ARM_ROOT})
