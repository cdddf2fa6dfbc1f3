/* kernel_path.h: name suffix and vector width of the instruction set for which a kernel_*.c is
 * compiled. */
#ifndef PHYSICS_KERNEL_PATH_H
#define PHYSICS_KERNEL_PATH_H

#ifndef SD_PATH
#define SD_PATH baseline
#endif
#define KERNEL_PASTE2(name, path) name##_##path
#define KERNEL_PASTE(name, path) KERNEL_PASTE2(name, path)
#define KERNEL(name) KERNEL_PASTE(name, SD_PATH)

#define KERNEL_NAME2(path) #path
#define KERNEL_NAME(path) KERNEL_NAME2(path)

#if defined(__AVX512F__)
#define VECTOR_WIDTH 8
#elif defined(__AVX2__)
#define VECTOR_WIDTH 4
#else
#define VECTOR_WIDTH 2
#endif

#endif
