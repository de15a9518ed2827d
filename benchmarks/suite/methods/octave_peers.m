% octave_peers.m FOLDER METHOD: re-identification from scratch by Octave's
% control package, METHOD arx or n4sid.
%
% FOLDER holds window_1.txt, window_2.txt, … (a row for each sample: outputs,
% then inputs, in deviations from rest) and settings.txt (p, m, samples of the
% step responses, length of a block). The order is that whose model, fitted
% without every fourth block, simulates those blocks with the least squared
% error, and is then fitted to everything. Writes step.txt: a column for each
% pair, output by output, and order.txt.
pkg load control
warning("off", "all");
arguments = argv();
folder = arguments{1};
method = arguments{2};
settings = load(fullfile(folder, "settings.txt"));
p = settings(1); m = settings(2); samples = settings(3); block = settings(4);
windows = {};
while exist(fullfile(folder, sprintf("window_%d.txt", numel(windows) + 1)), "file")
  windows{end+1} = load(fullfile(folder, sprintf("window_%d.txt", numel(windows) + 1)));
end

% Every fourth block is held out; what lies between is an experiment of its own.
function [parts, held] = split(window, block)
  held = false(rows(window), 1);
  parts = {};
  count = floor(rows(window) / block);
  first = 1;
  for b = 1:count
    last = b * block;
    if b == count, last = rows(window); end
    if mod(b, 4) == 3
      held((b-1)*block+1:last) = true;
      if (b-1)*block >= first, parts{end+1} = window(first:(b-1)*block, :); end
      first = last + 1;
    end
  end
  if first <= rows(window), parts{end+1} = window(first:end, :); end
end

function model = fit(parts, p, method, order)
  ys = cellfun(@(w) w(:, 1:p), parts, "UniformOutput", false);
  us = cellfun(@(w) w(:, p+1:end), parts, "UniformOutput", false);
  data = iddata(ys, us, 1);
  if strcmp(method, "arx")
    model = arx(data, "na", order, "nb", order);
  else
    model = n4sid(data, order);
  end
end

function y = simulate(model, u, p)
  y = zeros(rows(u), p);
  if isa(model, "ss")
    [A, B, C, D] = ssdata(model);
    x = zeros(rows(A), 1);
    for k = 1:rows(u)
      y(k, :) = (C * x + D * u(k, :)')';
      x = A * x + B * u(k, :)';
    end
  else
    [num, den] = tfdata(model);
    for i = 1:p
      for j = 1:columns(u)
        y(:, i) += filter(num{i, j}, den{i, j}, u(:, j));
      end
    end
  end
end

if strcmp(method, "arx"), orders = [10 20 40 60 80]; else orders = [2 4 8 16 30]; end
parts = {}; helds = {};
for w = 1:numel(windows)
  [own, helds{w}] = split(windows{w}, block);
  parts = [parts own];
end
best = Inf; best_order = orders(1);
for order = orders
  usable = parts(cellfun(@rows, parts) > 3 * order + 2);
  if isempty(usable), continue; end
  try
    model = fit(usable, p, method, order);
    loss = 0;
    for w = 1:numel(windows)
      errors = windows{w}(:, 1:p) - simulate(model, windows{w}(:, p+1:end), p);
      spread = std(windows{w}(:, 1:p));
      loss += sumsq((errors(helds{w}, :) ./ spread)(:));
    end
    if loss < best, best = loss; best_order = order; end
  catch
    fprintf(stderr, "%s of order %d failed: %s\n", method, order, lasterr());
  end
end
model = fit(windows, p, method, best_order);
steps = zeros(samples, p * m);
for j = 1:m
  u = zeros(samples, m);
  u(:, j) = 1;
  steps(:, j:m:end) = simulate(model, u, p);
end
dlmwrite(fullfile(folder, "step.txt"), steps, "delimiter", " ", "precision", 10);
dlmwrite(fullfile(folder, "order.txt"), best_order);
