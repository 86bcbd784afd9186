/* What util.h needs of Windows for functions that the drivers do not call. */
typedef unsigned long DWORD;
#define _fullpath(path, name, n)
#define UrlCreateFromPathA(path, uri, length, flags)
