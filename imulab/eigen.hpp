// Eigen with the memory layout of the library. Matrices cross from programs to the library and back, and Eigen aligns them by the widest registers
// that a source is compiled for. In a program for AVX (-mavx2, -march=native) whose library is not, Eigen has no explicit vectors here: so it
// aligns alike. Headers of imulab include this one in place of <Eigen/Core>; programs that use Eigen include one of imulab's first.
#pragma once

#include <cstddef>  // __GLIBC__

#ifndef IMULAB_EIGEN_ALIGNMENT  // bytes, of the compiled library: from its CMake target or pkg-config
#define IMULAB_EIGEN_ALIGNMENT 16
#endif

#if IMULAB_EIGEN_ALIGNMENT == 16 && defined(__SANITIZE_ADDRESS__) && defined(__GLIBC__) && defined(__LP64__)
#define IMULAB_EIGEN_MALLOC 1  // Eigen takes its blocks from malloc as they are; under the sanitizer it would put a header before them
#endif

#ifndef EIGEN_WORLD_VERSION  // Eigen is not included yet
#if IMULAB_EIGEN_ALIGNMENT == 16 && defined(__AVX__) && !defined(EIGEN_MAX_ALIGN_BYTES)
#define EIGEN_DONT_VECTORIZE
#define EIGEN_MAX_ALIGN_BYTES 16
#define EIGEN_MAX_STATIC_ALIGN_BYTES 16
#endif
#if defined(IMULAB_EIGEN_MALLOC) && !defined(EIGEN_MALLOC_ALREADY_ALIGNED)
#define EIGEN_MALLOC_ALREADY_ALIGNED 1
#endif
#endif

#include <Eigen/Core>

#if EIGEN_DEFAULT_ALIGN_BYTES != IMULAB_EIGEN_ALIGNMENT || (defined(IMULAB_EIGEN_MALLOC) && !EIGEN_MALLOC_ALREADY_ALIGNED)
#error \
    "Eigen's memory layout is not that of the compiled imulab, and the program would crash. Include imulab before Eigen in every source, or build imulab with the program's flags (-mavx2, -march=native, -fsanitize=address)"
#endif

namespace imulab {

using Eigen::Matrix3d;  // frames in names: C_nb takes a vector from frame b to frame n
using Eigen::Vector3d;

}  // namespace imulab
