// The output of ideal sensors: means of rate and specific force over each sample's interval, from the closed form of the motion.
#pragma once

#include "imulab/compensate.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/rig/motion.hpp"

#include <array>
#include <vector>

namespace imulab {

/// Means over intervals, by Gauss-Legendre quadrature of the closed form; exact while the rig rests, or turns fast and steadily about one axis.
class MeanMotion {
 public:
  MeanMotion(RigMotion motion, const Surroundings& surroundings);

  /// Means over samples begin .. begin + out's length; sample i's interval is (i, i + 1) * interval_s. The columns are equally long.
  void over(std::size_t begin, double interval_s, const MotionColumns& out) const;

 private:
  struct Piece {
    double begin, end;
    bool at_rest;
    double panel;  // s: longest interval of one quadrature
    bool size_effect;
    Surroundings around;             // with the accelerometers' positions in this piece
    Motion rest;                     // the constant motion where at rest
    Vector3d force_jump;             // integral [m/s] of the size effect of the rate's jump at `begin`
    double steady_rate;              // rad/s, of the one axis that turns steadily; else 0
    std::array<Motion, 5> harmonic;  // then: mean, cos, sin, cos and sin of twice the angle since `begin`
  };
  Motion at(std::size_t piece, double t) const;
  void find_harmonics(std::size_t piece);
  Motion integral(std::size_t piece, double begin, double end) const;
  Motion mean_across(std::size_t piece, double begin, double end) const;
  void means_inside(std::size_t piece, std::size_t begin, double interval_s, std::size_t first, std::size_t last, const MotionColumns& out) const;

  RigMotion motion_;
  Vector3d force_t_, rate_ie_t_;                  // gravity's reaction and Earth rate in the table's frame
  std::array<Matrix3d, 3> cross_, cross_square_;  // of the axes
  std::vector<Piece> pieces_;
};

}  // namespace imulab
