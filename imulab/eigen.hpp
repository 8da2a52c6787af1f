// Includes Eigen with the memory layout of the library. Programs and library exchange matrices, and Eigen aligns matrices for the widest registers
// for which a source is compiled. If a program is compiled for AVX (-mavx2, -march=native) but the library is not, this header disables explicit
// vectorization so that both align alike. Headers of imulab include it instead of <Eigen/Core>; programs include an imulab header before Eigen.
#pragma once

#include <cstddef>  // __GLIBC__

#ifndef IMULAB_EIGEN_ALIGNMENT  // alignment [bytes] of the compiled library, from its CMake target or pkg-config
#define IMULAB_EIGEN_ALIGNMENT 16
#endif

#if IMULAB_EIGEN_ALIGNMENT == 16 && defined(__SANITIZE_ADDRESS__) && defined(__GLIBC__) && defined(__LP64__)
#define IMULAB_EIGEN_MALLOC 1  // Eigen uses malloc's blocks directly; under the sanitizer it would put a header before them
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

using Eigen::Matrix3d;  // names state frames: C_nb transforms a vector from frame b to frame n
using Eigen::Vector3d;

}  // namespace imulab
