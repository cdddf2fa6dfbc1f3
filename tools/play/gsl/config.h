/* config.h: the settings of GSL for WebAssembly, in place of those that its configure script
 * finds. */
#ifndef SLIPDISK_GSL_CONFIG_H
#define SLIPDISK_GSL_CONFIG_H

#define VERSION "2.7.1"
#define HAVE_DECL_HYPOT 1
#define HAVE_DECL_LOG1P 1
#define HAVE_DECL_EXPM1 1
#define HAVE_DECL_ISINF 1
#define HAVE_DECL_ISFINITE 1
#define HAVE_DECL_ISNAN 1
#define HAVE_DECL_LDEXP 1
#define HAVE_DECL_FREXP 1
#define HAVE_PRINTF_LONGDOUBLE 1
#define GSL_COERCE_DBL(x) (x)
#define RETURN_IF_NULL(x)                                                                          \
  if (!x) return
#define GSL_DISABLE_DEPRECATED 1

#endif
