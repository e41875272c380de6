/**
 * Small symmetric matrices: Cholesky factors and eigenvalues with vectors, in one array each by rows.
 *
 * Written here because a slider asks for an answer within a frame: for 60 coordinates ml-matrix 6.15 takes two to three times as long, as it
 * keeps a matrix in an array a row and multiplies by inverses in place of triangular factors; and the page would grow by 70 kB.
 */

/** L of A = L Lᵀ, into the lower triangle of `a`; false where A is not positive definite. */
export function cholesky(a: Float64Array, n: number): boolean {
  for (let j = 0; j < n; j++) {
    const rowJ = j * n;
    let d = a[rowJ + j]!;
    for (let k = 0; k < j; k++) d -= a[rowJ + k]! * a[rowJ + k]!;
    if (!(d > 0)) return false;
    const root = Math.sqrt(d);
    a[rowJ + j] = root;
    for (let i = j + 1; i < n; i++) {
      const rowI = i * n;
      let s = a[rowI + j]!;
      for (let k = 0; k < j; k++) s -= a[rowI + k]! * a[rowJ + k]!;
      a[rowI + j] = s / root;
    }
  }
  return true;
}

/** L⁻¹ A L⁻ᵀ into `a`, of the whole symmetric A. */
export function congruence(a: Float64Array, l: Float64Array, n: number): void {
  // Rows of L⁻¹ A, then the same of its transpose, which A symmetric makes the same loop.
  for (let pass = 0; pass < 2; pass++) {
    for (let i = 0; i < n; i++) {
      const row = i * n;
      for (let k = 0; k < i; k++) {
        const f = l[row + k]!;
        if (f === 0) continue;
        const other = k * n;
        for (let j = 0; j < n; j++) a[row + j]! -= f * a[other + j]!;
      }
      const d = 1 / l[row + i]!;
      for (let j = 0; j < n; j++) a[row + j]! *= d;
    }
    transpose(a, n);
  }
}

function transpose(a: Float64Array, n: number): void {
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < i; j++) {
      const t = a[i * n + j]!;
      a[i * n + j] = a[j * n + i]!;
      a[j * n + i] = t;
    }
  }
}

/** L⁻ᵀ x into `x`. */
export function backward(l: Float64Array, n: number, x: Float64Array): void {
  for (let i = n - 1; i >= 0; i--) {
    const v = (x[i]! /= l[i * n + i]!);
    for (let k = 0; k < i; k++) x[k]! -= l[i * n + k]! * v;
  }
}

/**
 * Eigenvalues of a symmetric matrix, ascending, and its vectors as the rows of `vectors`; false where QL does not converge.
 *
 * Householder's reduction to a tridiagonal matrix and QL with implicit shifts: R. S. Martin, C. Reinsch, J. H. Wilkinson, Numerische
 * Mathematik 11 (1968) 181-195; H. Bowdler, R. S. Martin, C. Reinsch, J. H. Wilkinson, ibid. 293-306. Vectors are kept as rows, so that
 * rotations run along memory.
 */
export function symmetricEigen(a: Float64Array, n: number, values: Float64Array, vectors: Float64Array): boolean {
  const d = values, e = new Float64Array(n), v = vectors;
  v.set(a.subarray(0, n * n));
  // v holds the matrix; column j of the textbook's z is row j of v.
  const p = new Float64Array(n);
  for (let i = n - 1; i > 0; i--) {
    const row = i * n;
    let scale = 0;
    for (let k = 0; k < i; k++) scale += Math.abs(v[row + k]!);
    if (i === 1 || scale === 0) {
      e[i] = v[row + i - 1]!;
      d[i] = 0;
      continue;
    }
    let h = 0;
    for (let k = 0; k < i; k++) {
      const u = (v[row + k]! /= scale);
      h += u * u;
    }
    const f = v[row + i - 1]!;
    const g = f >= 0 ? -Math.sqrt(h) : Math.sqrt(h);
    e[i] = scale * g;
    h -= f * g;
    v[row + i - 1] = f - g;
    d[i] = h;
    // p = A u / h of the leading block, by its lower triangle.
    p.fill(0, 0, i);
    for (let j = 0; j < i; j++) {
      const rowJ = j * n, uj = v[row + j]!;
      let s = v[rowJ + j]! * uj;
      for (let k = 0; k < j; k++) {
        s += v[rowJ + k]! * v[row + k]!;
        p[k]! += v[rowJ + k]! * uj;
      }
      p[j]! += s;
    }
    let q = 0;
    for (let j = 0; j < i; j++) {
      p[j]! /= h;
      q += p[j]! * v[row + j]!;
    }
    const c = q / (2 * h);
    for (let j = 0; j < i; j++) p[j]! -= c * v[row + j]!;
    for (let j = 0; j < i; j++) {
      const rowJ = j * n, uj = v[row + j]!, pj = p[j]!;
      for (let k = 0; k <= j; k++) v[rowJ + k]! -= uj * p[k]! + pj * v[row + k]!;
    }
  }
  // The product of the reflections, from the smallest block up; u of block i stands in row i.
  const q = new Float64Array(n * n);
  const diagonal = new Float64Array(n);
  for (let i = 0; i < n; i++) diagonal[i] = v[i * n + i]!;
  for (let i = 0; i < n; i++) {
    const h = d[i]!, u = i * n;
    if (i > 0 && h !== 0) {
      for (let r = 0; r < i; r++) {
        const row = r * n;
        let g = 0;
        for (let k = 0; k < i; k++) g += v[u + k]! * q[row + k]!;
        g /= h;
        if (g !== 0) for (let k = 0; k < i; k++) q[row + k]! -= g * v[u + k]!;
      }
    }
    q[u + i] = 1;
  }
  v.set(q);
  d.set(diagonal);
  for (let i = 1; i < n; i++) e[i - 1] = e[i]!;
  e[n - 1] = 0;
  return tridiagonal(d, e, v, n);
}

/** QL with implicit shifts on the tridiagonal matrix d, e; rows of `v` are turned along and sorted by ascending d. */
function tridiagonal(d: Float64Array, e: Float64Array, v: Float64Array, n: number): boolean {
  for (let l = 0; l < n; l++) {
    for (let round = 0; ; round++) {
      let m = l;
      for (; m < n - 1; m++) {
        const size = Math.abs(d[m]!) + Math.abs(d[m + 1]!);
        if (Math.abs(e[m]!) <= Number.EPSILON * size) break;
      }
      if (m === l) break;
      if (round === 60) return false;
      let g = (d[l + 1]! - d[l]!) / (2 * e[l]!);
      let r = Math.hypot(g, 1);
      g = d[m]! - d[l]! + e[l]! / (g + (g >= 0 ? r : -r));
      let s = 1, c = 1, p = 0, i = m - 1;
      for (; i >= l; i--) {
        const f = s * e[i]!, b = c * e[i]!;
        r = Math.hypot(f, g);
        e[i + 1] = r;
        if (r === 0) {
          d[i + 1]! -= p;
          e[m] = 0;
          break;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1]! - p;
        r = (d[i]! - g) * s + 2 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
        const upper = (i + 1) * n, lower = i * n;
        for (let k = 0; k < n; k++) {
          const y = v[upper + k]!, x = v[lower + k]!;
          v[upper + k] = s * x + c * y;
          v[lower + k] = c * x - s * y;
        }
      }
      if (r === 0 && i >= l) continue;
      d[l]! -= p;
      e[l] = g;
      e[m] = 0;
    }
  }
  for (let i = 0; i < n - 1; i++) {
    let least = i;
    for (let k = i + 1; k < n; k++) if (d[k]! < d[least]!) least = k;
    if (least === i) continue;
    [d[i], d[least]] = [d[least]!, d[i]!];
    const kept = v.slice(i * n, (i + 1) * n);
    v.copyWithin(i * n, least * n, (least + 1) * n);
    v.set(kept, least * n);
  }
  return true;
}
