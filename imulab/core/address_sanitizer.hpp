// IMULAB_ADDRESS_SANITIZER: defined where the code is under it. GCC and clang each say so in a way of their own.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define IMULAB_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define IMULAB_ADDRESS_SANITIZER
#endif
#endif
