# The command imulab on Debian 12: docker build -t imulab . && docker run --rm -v "$PWD:/data" imulab inspect log.csv
FROM debian:12-slim AS build
ENV DEBIAN_FRONTEND=noninteractive
RUN apt-get update && apt-get install -y --no-install-recommends g++ cmake ninja-build pkg-config dpkg-dev file ca-certificates \
      libeigen3-dev libgeographiclib-dev libceres-dev libboost-math-dev librandom123-dev libtbb-dev libcli11-dev libtomlplusplus-dev nlohmann-json3-dev \
      libfmt-dev libyaml-cpp-dev libsqlite3-dev liblz4-dev libzstd-dev libbz2-dev zlib1g-dev libdeflate-dev libhdf5-dev libmatio-dev libjs-dygraphs
COPY . /imulab
WORKDIR /imulab
RUN cmake -S . -B /build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DIMULAB_TESTS=OFF -DIMULAB_BENCHMARKS=OFF -DIMULAB_PYTHON=OFF \
 && cmake --build /build && cd /build && cpack -G DEB -D CPACK_COMPONENTS_ALL=command

FROM debian:12-slim
RUN --mount=from=build,source=/build/packages,target=/packages \
    apt-get update && apt-get install -y --no-install-recommends /packages/imulab_*.deb && rm -rf /var/lib/apt/lists/*
WORKDIR /data
ENTRYPOINT ["imulab"]
