/* HIDDEN_BEGIN ... HIDDEN_END around declarations: functions that other binaries do not see, whatever the
 * compiler's flags. Only the functions of FMI are exported then, from sources/ too. */
#ifndef IT2HYS_HIDDEN_H
#define IT2HYS_HIDDEN_H

#if defined __GNUC__ && !defined _WIN32
#define HIDDEN_BEGIN _Pragma("GCC visibility push(hidden)")
#define HIDDEN_END _Pragma("GCC visibility pop")
#else /* on Windows nothing is visible that is not exported */
#define HIDDEN_BEGIN
#define HIDDEN_END
#endif

#endif
