% Octave writes .mat of versions 5 and 4, as MATLAB's save does: octave --no-gui matlab_files.m
i = (0:39)';
t = 8 * (i + 1) / 1000;
gyro = (64 * (1:3) + i) / 1024;
accel = (i - 8 * (0:2)) / 256 + [0 0 9.75];
imu.gyro = gyro;
imu.accel = accel;
imu.counts = int16(1000 * (1:3) - 7 * i);
stamp = int64(1700000000000000000) + int64(8000000) * int64(i + 1);
unit = "rad/s";
save("-v7", "octave_v7.mat", "t", "stamp", "imu", "unit");
save("-v6", "octave_v6.mat", "t", "stamp", "imu", "unit");
save("-v4", "octave_v4.mat", "t", "gyro", "accel");
