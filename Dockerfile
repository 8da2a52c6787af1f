# The command imulab on Debian 13: docker build -t imulab . && docker run --rm -v "$PWD:/data" imulab inspect log.csv
FROM debian:13-slim AS build
ENV DEBIAN_FRONTEND=noninteractive
RUN rm /etc/apt/apt.conf.d/docker-clean # packages stay in the cache
COPY dependencies.txt /
RUN --mount=type=cache,target=/var/cache/apt,sharing=locked --mount=type=cache,target=/var/lib/apt,sharing=locked \
    apt-get update && apt-get install -y --no-install-recommends g++ cmake dpkg-dev file ca-certificates \
      $(awk '/^# To develop/ { exit } !/^#/ { print $1 }' /dependencies.txt)
COPY . /imulab
WORKDIR /imulab
RUN --mount=type=cache,target=/root/.cache/ccache \
    cmake -S . -B /build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DIMULAB_TESTS=OFF -DIMULAB_BENCHMARKS=OFF -DIMULAB_PYTHON=OFF \
 && cmake --build /build && cd /build && cpack -G DEB -D CPACK_COMPONENTS_ALL=command

FROM debian:13-slim
RUN --mount=from=build,source=/build/packages,target=/packages \
    apt-get update && apt-get install -y --no-install-recommends /packages/imulab_*.deb libarchive13 && rm -rf /var/lib/apt/lists/*
WORKDIR /data
ENTRYPOINT ["imulab"]
