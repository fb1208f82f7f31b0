// Spells Greek letters, because few keyboards have them: the search finds "Λ z" as "lambda z".

const NAMES: Record<string, string> = {
  Φ: "phi", Λ: "lambda", λ: "lambda", σ: "sigma", δ: "delta", α: "alpha", ν: "nu", φ: "phi", θ: "theta", ψ: "psi",
};

/** `label` with the names of its Greek letters in place of the letters, and without accents. */
export function spelled(label: string): string {
  const plain = label.normalize("NFD").replace(/\p{Mn}/gu, "").replace("₀", "0").replace("₁", "1").replace("₂", "2");
  return [...plain].map((letter) => NAMES[letter] ?? letter).join("");
}
