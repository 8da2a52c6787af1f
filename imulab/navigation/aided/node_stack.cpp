#include "imulab/navigation/aided/node_stack.hpp"

#include <span>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t full_block = std::size_t{4} << 20;  // in numbers: 32 MB

/// Appends values as numbers; `NodeUnpacker` reads them in the same order. Integers below 2^53 are exact.
class NodePacker {
 public:
  explicit NodePacker(std::vector<double>& to) : to_(to) {}
  void operator()(double x) { to_.push_back(x); }
  void operator()(std::size_t n) { to_.push_back(static_cast<double>(n)); }
  template <class Dense>
  void operator()(const Eigen::PlainObjectBase<Dense>& m) {
    if constexpr (Dense::SizeAtCompileTime == Eigen::Dynamic)
      (*this)(static_cast<std::size_t>(m.rows())), (*this)(static_cast<std::size_t>(m.cols()));
    to_.insert(to_.end(), m.data(), m.data() + m.size());
  }
  /// Appends the lower triangle.
  void symmetric(const MatrixXd& m) {
    (*this)(static_cast<std::size_t>(m.rows()));
    for (Index k = 0; k < m.cols(); ++k) to_.insert(to_.end(), m.data() + k * m.rows() + k, m.data() + (k + 1) * m.rows());
  }
  template <class Element>
  void list(std::vector<Element>& all, auto&& each) {
    (*this)(all.size());
    for (Element& one : all) each(one);
  }

 private:
  std::vector<double>& to_;
};

class NodeUnpacker {
 public:
  explicit NodeUnpacker(const double* from) : from_(from) {}
  void operator()(double& x) { x = *from_++; }
  void operator()(std::size_t& n) { n = static_cast<std::size_t>(*from_++); }
  template <class Dense>
  void operator()(Eigen::PlainObjectBase<Dense>& m) {
    if constexpr (Dense::SizeAtCompileTime == Eigen::Dynamic) {
      const Index rows = static_cast<Index>(from_[0]), cols = static_cast<Index>(from_[1]);
      m.resize(rows, cols), from_ += 2;
    }
    m = Eigen::Map<const Dense>(from_, m.rows(), m.cols()), from_ += m.size();
  }
  void symmetric(MatrixXd& m) {
    const auto n = static_cast<Index>(*from_++);
    m.resize(n, n);
    for (Index k = 0; k < n; ++k)
      for (Index i = k; i < n; ++i) m(i, k) = m(k, i) = *from_++;
  }
  template <class Element>
  void list(std::vector<Element>& all, auto&& each) {
    all.resize(static_cast<std::size_t>(*from_++));
    for (Element& one : all) each(one);
  }

 private:
  const double* from_;
};

void transfer(auto& by, EpochRows& e) {
  by(e.observation), by(e.rows.residual), by(e.rows.derivative), by(e.rows.variance);
  by.list(e.rows.source, [&](std::size_t& source) { by(source); });
  by(e.weight), by(e.innovation), by(e.innovation_variance), by(e.gain);
}

void transfer(auto& by, Node& node) {
  by(node.samples), by(node.reference.x), by(node.error);
  NavigationState& motion = node.reference.motion;
  by(motion.q_nb.coeffs()), by(motion.velocity), by(motion.latitude), by(motion.longitude), by(motion.height);
  by.symmetric(node.covariance);
  Transition& next = node.next;
  by(next.motion), by(next.gyro), by(next.accel), by(next.decay), by(next.driven), by(next.interval), by(next.motion_kind);
  for (std::vector<EpochRows>* all : {&node.rows, &node.withheld}) by.list(*all, [&](EpochRows& e) { transfer(by, e); });
}

}  // namespace

void NodeStack::push(Node node) {
  if (size_++ > 0) {
    if (block_.size() >= full_block) {
      if (!file_) file_.emplace();
      file_->append(std::as_bytes(std::span(block_)));
      filed_.push_back(block_.size());
      block_.clear();
    }
    const std::size_t before = block_.size();
    if (before == 0) block_.reserve(full_block + full_block / 64);  // does not move as it grows
    NodePacker pack(block_);
    transfer(pack, last_);
    numbers_.push_back(block_.size() - before);
  }
  last_ = std::move(node);
}

void NodeStack::replace(Node node) {
  *this = {};
  push(std::move(node));
}

Node NodeStack::pop() {
  Node out = std::move(last_);
  last_ = {};
  if (--size_ == 0) return out;
  if (block_.empty()) {
    block_.resize(filed_.back());
    file_->take_back(std::as_writable_bytes(std::span(block_)));
    filed_.pop_back();
  }
  const std::size_t begin = block_.size() - numbers_.back();
  NodeUnpacker unpack(block_.data() + begin);
  transfer(unpack, last_);
  block_.resize(begin), numbers_.pop_back();
  return out;
}

}  // namespace imulab::aided
