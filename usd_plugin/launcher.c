/* The program `usdtailor` of the Python package: its code is in the library that the OpenUSD plugins share. */

#include <signal.h>

int usdtailor_main(void);

int main(void)
{
    /* As programs in Rust do: a closed pipe is an error of writing, and not the end of the program. */
    signal(SIGPIPE, SIG_IGN);
    return usdtailor_main();
}
